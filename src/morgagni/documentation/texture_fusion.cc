// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/texture_fusion.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "morgagni/documentation/internal/detail_alignment.h"
#include "morgagni/documentation/internal/frame_look.h"
#include "morgagni/documentation/internal/soft_layer.h"
#include "morgagni/documentation/internal/texel_map.h"
#include "morgagni/documentation/skin_texture_io.h"
#include "morgagni/geometry/rigid.h"

namespace mor {
namespace {

using Eigen::Vector3f;
using internal::FrameLook;
using internal::KnownDetail;
using internal::SkinSight;
using internal::SoftLayer;
using internal::Texel;

constexpr Rgb8 kUnseenColor = {96, 96, 104};
constexpr std::size_t kMaxDetails = 16000;  ///< A frame is aligned on.
constexpr std::size_t kFewTexels = 50;
constexpr float kClearlyBetter = 1.12F;  ///< Else a texel keeps its frame: fewer borders.
constexpr double kLeastSkinShare = 0.01;
constexpr std::size_t kFewInCommon = 300;  ///< Texels to compare sharpness on.
constexpr double kExposureS = 1.0 / 60.0;  ///< Taken for what no camera tells.
constexpr double kFrameS = 1.0 / 30.0;
/// A bound holds errors that all frames share; from frame to frame poses differ by much less.
constexpr double kBoundOfJitter = 8.0;
constexpr double kLeastPoseSdMm = 0.15;
constexpr int kGutterPx = 4;
constexpr int kRestoreRounds = 6;

/// What a texel has got.
struct TexelState {
  Vector3f color = Vector3f::Zero();  ///< In the texture's exposure.
  Vector3f soft = Vector3f::Zero();   ///< Of its surroundings in the same frame.
  float worth = 0.0F;                 ///< 0: never seen.
  float sharpness = 1.0F;             ///< Of its frame, against the first frame's.
  TexelSource source;
};

float brightness(const Vector3f& color) {
  return 0.3F * color.x() + 0.59F * color.y() + 0.11F * color.z();
}

std::uint8_t to_byte(float value) {
  return static_cast<std::uint8_t>(std::clamp(value + 0.5F, 0.0F, 255.0F));
}

Rgb8 to_rgb(const Vector3f& color) {
  return {to_byte(color.x()), to_byte(color.y()), to_byte(color.z())};
}

Vector3f to_vector(const Rgb8& color) {
  return {static_cast<float>(color.r), static_cast<float>(color.g), static_cast<float>(color.b)};
}

Result<void> check_frame(const RgbdFrame& frame) {
  if (!frame.calibration) {
    return make_error(ErrorCode::kInvalidArgument, "a frame to melt needs its calibration");
  }
  const auto has_size = [](const auto& image, const PinholeCamera& camera) {
    return image.width() == camera.width_px && image.height() == camera.height_px;
  };
  if (has_size(frame.depth_mm, frame.calibration->depth) &&
      has_size(frame.color, frame.calibration->color)) {
    return {};
  }
  return make_error(ErrorCode::kInvalidArgument,
                    fmt::format("frame {} has a colour picture of {}x{} px, its calibration says "
                                "{}x{} px",
                                frame.frame_id,
                                frame.color.width(),
                                frame.color.height(),
                                frame.calibration->color.width_px,
                                frame.calibration->color.height_px));
}

}  // namespace

std::string_view to_string(FusionOutcome outcome) {
  switch (outcome) {
    case FusionOutcome::kFused:
      return "fused";
    case FusionOutcome::kNothingNew:
      return "nothing new";
    case FusionOutcome::kUncertain:
      return "uncertain";
    case FusionOutcome::kMoving:
      return "moving";
    case FusionOutcome::kNoSkin:
      return "no skin";
    case FusionOutcome::kMisfit:
      return "misfit";
    case FusionOutcome::kFull:
      return "full";
  }
  return "";
}

Result<void> TextureFusionOptions::check() const {
  const auto refuse = [](std::string_view what, std::string_view limits, double value) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("{} must be {}, got {}", what, limits, value));
  };
  if (!(max_bound_mm > 0.0)) return refuse("max_bound_mm", "above 0", max_bound_mm);
  if (!(max_motion_px > 0.0)) return refuse("max_motion_px", "above 0", max_motion_px);
  if (!(max_view_angle_rad > 0.0 && max_view_angle_rad <= 1.5)) {
    return refuse("max_view_angle_rad", "in (0, 1.5]", max_view_angle_rad);
  }
  if (!(clutter_margin_mm >= 0.0 && clutter_margin_mm <= 200.0)) {
    return refuse("clutter_margin_mm", "in [0, 200]", clutter_margin_mm);
  }
  return {};
}

struct TextureFusion::Impl {
  Impl(std::shared_ptr<const SkinAtlas> of_skin, const TextureFusionOptions& chosen)
      : atlas(std::move(of_skin)),
        options(chosen),
        texels(internal::texels_of(*atlas)),
        states(texels.size()),
        soft_layer(atlas->mesh) {}

  using TimePoint = std::chrono::steady_clock::time_point;

  /// A texel that a frame shows better than what there is.
  struct Candidate {
    std::size_t texel;
    SkinSight sight;
    Vector3f soft;
    float worth;
  };

  FusionOutcome add(const RgbdFrame& frame,
                    const Eigen::Isometry3d& ct_from_depth,
                    double bound_mm,
                    std::int64_t captured_unix_ms);
  /// How far the picture has moved since the frame before, px/s. None: not known.
  std::optional<double> speed_px_per_s(const RgbdFrame& frame,
                                       const Eigen::Isometry3d& color_from_ct);
  /// How much detail the frame has, against the first frame's: compared with what the texture has
  /// at the same places, whose frames' own sharpness is known.
  float sharpness_of(const FrameLook& look, float gain) const;
  bool align(FrameLook& look,
             const Eigen::Isometry3d& color_from_ct,
             const Vector3f& gains,
             double bound_mm);
  std::vector<Candidate> candidates(const FrameLook& look,
                                    const Vector3f& gains,
                                    float frame_worth) const;
  void take(const FrameLook& look,
            const std::vector<Candidate>& candidates,
            const Vector3f& gains,
            float sharpness);
  void restore_soft_layer();

  std::shared_ptr<const SkinAtlas> atlas;
  TextureFusionOptions options;
  std::vector<Texel> texels;
  std::vector<TexelState> states;
  SoftLayer soft_layer;
  std::vector<TextureFrame> frames;
  std::uint64_t version = 0;
  Vector3f last_gains = Vector3f::Ones();
  std::optional<double> last_shift_mm;
  std::optional<std::pair<TimePoint, Eigen::Isometry3d>> last_seen;
};

std::optional<double> TextureFusion::Impl::speed_px_per_s(const RgbdFrame& frame,
                                                          const Eigen::Isometry3d& color_from_ct) {
  const auto before = std::exchange(last_seen, {{frame.captured_at, color_from_ct}});
  if (!before) return std::nullopt;
  const double passed_s = std::chrono::duration<double>(frame.captured_at - before->first).count();
  if (!(passed_s > 0.0 && passed_s < 0.6)) return std::nullopt;
  const Eigen::Vector3d middle = atlas->mesh.bounds().center().cast<double>();
  const auto now_px = frame.calibration->color.project(color_from_ct * middle);
  const auto before_px = frame.calibration->color.project(before->second * middle);
  if (!now_px || !before_px) return std::nullopt;
  return (*now_px - *before_px).norm() / passed_s;
}

float TextureFusion::Impl::sharpness_of(const FrameLook& look, float gain) const {
  const std::size_t step = std::max<std::size_t>(1, texels.size() / kMaxDetails);
  double of_frame = 0.0;
  double of_texture = 0.0;
  double sharpness = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < texels.size(); i += step) {
    const auto& state = states[i];
    if (state.worth <= 0.0F) continue;
    const auto sight = look.sight(texels[i].at_mm, texels[i].normal);
    if (!sight) continue;
    const Eigen::Vector4f soft = look.soft_color(*sight);
    if (soft.w() < 0.5F) continue;
    const float here = gain * (brightness(look.color(*sight)) - brightness(soft.head<3>()));
    const float before = brightness(state.color) - brightness(state.soft);
    of_frame += static_cast<double>(here * here);
    of_texture += static_cast<double>(before * before);
    sharpness += static_cast<double>(state.sharpness);
    ++count;
  }
  if (count < kFewInCommon || of_texture <= 0.0) return 1.0F;
  const double ratio = std::clamp(std::sqrt(of_frame / of_texture), 0.25, 4.0);
  return static_cast<float>(std::clamp(ratio * sharpness / static_cast<double>(count), 0.1, 10.0));
}

bool TextureFusion::Impl::align(FrameLook& look,
                                const Eigen::Isometry3d& color_from_ct,
                                const Vector3f& gains,
                                double bound_mm) {
  last_shift_mm.reset();
  if (!options.aligns_frames || frames.empty()) return true;
  std::vector<KnownDetail> details;
  const std::size_t step = std::max<std::size_t>(1, texels.size() / kMaxDetails);
  for (std::size_t i = 0; i < texels.size(); i += step) {
    const auto& state = states[i];
    if (state.worth <= 0.0F) continue;
    details.push_back(
        {texels[i].at_mm, texels[i].normal, brightness(state.color) - brightness(state.soft)});
  }
  const double pose_sd_mm = std::max(kLeastPoseSdMm, bound_mm / kBoundOfJitter);
  const auto aligned =
      internal::align_details(look, details, color_from_ct, gains.mean(), pose_sd_mm);
  if (!aligned) return true;
  last_shift_mm = aligned->shift_mm;
  return aligned->shift_mm <= std::max(3.0, 2.0 * bound_mm);
}

std::vector<TextureFusion::Impl::Candidate> TextureFusion::Impl::candidates(
    const FrameLook& look, const Vector3f& gains, float frame_worth) const {
  std::vector<Candidate> result;
  // Finer than the atlas adds little.
  const auto finest = static_cast<float>(1.3 * atlas->px_per_mm);
  for (std::size_t i = 0; i < texels.size(); ++i) {
    const Texel& texel = texels[i];
    const auto sight = look.sight(texel.at_mm, texel.normal);
    if (!sight) continue;
    float worth = frame_worth * std::min(sight->px_per_mm, finest);
    if (worth <= kClearlyBetter * states[i].worth) continue;
    const Eigen::Vector4f soft = look.soft_color(*sight);
    if (soft.w() <= 0.0F) continue;
    const Vector3f leveled = soft.head<3>().cwiseProduct(gains);
    // Beside clutter less is known of the surroundings; in a shadow colours are not the skin's.
    worth *= std::min(1.0F, 0.25F + soft.w());
    const auto& corners = atlas->mesh.triangles[texel.triangle];
    if (const auto usual = soft_layer.color(corners, texel.share)) {
      const float shade = std::log(brightness(leveled) / std::max(1.0F, brightness(*usual)));
      worth *= std::exp(-0.5F * shade * shade / (0.15F * 0.15F));
    }
    if (worth <= kClearlyBetter * states[i].worth) continue;
    result.push_back({i, *sight, leveled, worth});
  }
  return result;
}

void TextureFusion::Impl::take(const FrameLook& look,
                               const std::vector<Candidate>& candidates,
                               const Vector3f& gains,
                               float sharpness) {
  const auto frame = static_cast<std::uint32_t>(frames.size() - 1);
  for (const auto& [texel, sight, soft, worth] : candidates) {
    states[texel] = {.color = look.color(sight).cwiseProduct(gains),
                     .soft = soft,
                     .worth = worth,
                     .sharpness = sharpness,
                     .source = {.frame = frame,
                                .angle_rad = std::acos(std::clamp(sight.cosine, -1.0F, 1.0F)),
                                .distance_mm = sight.distance_mm,
                                .px_per_mm = sight.px_per_mm}};
  }
}

FusionOutcome TextureFusion::Impl::add(const RgbdFrame& frame,
                                       const Eigen::Isometry3d& ct_from_depth,
                                       double bound_mm,
                                       std::int64_t captured_unix_ms) {
  const Eigen::Isometry3d color_from_ct =
      frame.calibration->color_from_depth * ct_from_depth.inverse();
  const auto speed = speed_px_per_s(frame, color_from_ct);
  if (speed && *speed * kFrameS > options.max_motion_px) return FusionOutcome::kMoving;
  FrameLook look(frame,
                 atlas->mesh,
                 color_from_ct,
                 {.clutter_margin_mm = options.clutter_margin_mm,
                  .depth_tolerance_mm = 6.0 + std::min(bound_mm, 4.0),
                  .least_cosine = static_cast<float>(std::cos(options.max_view_angle_rad))});
  if (look.skin_share() < kLeastSkinShare) return FusionOutcome::kNoSkin;
  auto samples = soft_layer.look(look);
  const Vector3f gains =
      frames.empty() ? Vector3f(Vector3f::Ones()) : soft_layer.gains(samples).value_or(last_gains);
  if (!(gains.minCoeff() > 0.2F && gains.maxCoeff() < 5.0F)) return FusionOutcome::kMisfit;
  if (!align(look, color_from_ct, gains, bound_mm)) return FusionOutcome::kMisfit;
  if (last_shift_mm) samples = soft_layer.look(look);
  last_gains = gains;
  soft_layer.add(
      samples, gains, std::chrono::duration<double>(frame.captured_at.time_since_epoch()).count());
  const double smear_px = speed.value_or(0.0) * kExposureS;
  const double sureness = 1.0 / (1.0 + bound_mm * bound_mm / 9.0);
  const float sharpness = sharpness_of(look, gains.mean());
  const auto frame_worth = static_cast<float>(sureness / (1.0 + smear_px * smear_px)) * sharpness;
  const auto better = candidates(look, gains, frame_worth);
  ++version;
  if (better.size() < kFewTexels) return FusionOutcome::kNothingNew;
  frames.push_back({.frame_id = frame.frame_id,
                    .captured_unix_ms = captured_unix_ms,
                    .ct_from_color = look.color_from_ct().cast<double>().inverse(),
                    .bound_mm = bound_mm});
  frames.back().ct_from_color = orthonormalized(frames.back().ct_from_color);
  take(look, better, gains, sharpness);
  return FusionOutcome::kFused;
}

/// Gives each vertex its texels' mean, and smooths over the mesh as far as a frame's colours are
/// softened.
void TextureFusion::Impl::restore_soft_layer() {
  const auto& mesh = atlas->mesh;
  std::vector<Eigen::Vector4f> colors(mesh.vertices.size(), Eigen::Vector4f::Zero());
  std::vector<float> cosines(mesh.vertices.size(), 0.0F);
  for (std::size_t i = 0; i < texels.size(); ++i) {
    if (states[i].worth <= 0.0F) continue;
    const auto& corners = mesh.triangles[texels[i].triangle];
    for (std::size_t corner = 0; corner < 3; ++corner) {
      Eigen::Vector4f value;
      value << states[i].color, 1.0F;
      const float share = texels[i].share[static_cast<Eigen::Index>(corner)];
      colors[corners[corner]] += share * value;
      cosines[corners[corner]] =
          std::max(cosines[corners[corner]], std::cos(states[i].source.angle_rad));
    }
  }
  for (auto& color : colors)
    color = color.w() > 1e-3F ? Eigen::Vector4f(color / color.w())
                              : Eigen::Vector4f(Eigen::Vector4f::Zero());
  for (int round = 0; round < kRestoreRounds; ++round) {
    auto sums = colors;
    for (const auto& [a, b, c] : mesh.triangles) {
      const Eigen::Vector4f sum = colors[a] + colors[b] + colors[c];
      for (const auto corner : {a, b, c}) {
        if (colors[corner].w() > 0.0F) sums[corner] += sum;
      }
    }
    for (std::size_t i = 0; i < sums.size(); ++i) {
      if (sums[i].w() > 0.0F) colors[i] = sums[i] / sums[i].w();
    }
  }
  for (std::uint32_t i = 0; i < colors.size(); ++i) {
    if (colors[i].w() > 0.0F) soft_layer.restore(i, colors[i].head<3>(), cosines[i]);
  }
  for (std::size_t i = 0; i < texels.size(); ++i) {
    if (states[i].worth <= 0.0F) continue;
    const auto& corners = mesh.triangles[texels[i].triangle];
    states[i].soft = soft_layer.color(corners, texels[i].share).value_or(states[i].color);
  }
}

TextureFusion::TextureFusion(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TextureFusion::TextureFusion(TextureFusion&&) noexcept = default;
TextureFusion& TextureFusion::operator=(TextureFusion&&) noexcept = default;
TextureFusion::~TextureFusion() = default;

Result<TextureFusion> TextureFusion::create(std::shared_ptr<const SkinAtlas> atlas,
                                            const TextureFusionOptions& options) {
  MOR_CHECK(options.check());
  if (!atlas || atlas->mesh.normals.size() != atlas->mesh.vertices.size()) {
    return make_error(ErrorCode::kInvalidArgument,
                      "a texture is melted onto the atlas of a skin with normals");
  }
  MOR_CHECK(atlas->check());
  return TextureFusion(std::make_unique<Impl>(std::move(atlas), options));
}

Result<FusionOutcome> TextureFusion::add(const RgbdFrame& frame,
                                         const Eigen::Isometry3d& ct_from_depth,
                                         std::optional<double> bound_mm,
                                         std::int64_t captured_unix_ms) {
  MOR_CHECK(check_frame(frame));
  if (!bound_mm || !(*bound_mm <= impl_->options.max_bound_mm)) return FusionOutcome::kUncertain;
  if (impl_->frames.size() >= kMaxTextureFrames) return FusionOutcome::kFull;
  return impl_->add(frame, ct_from_depth, *bound_mm, captured_unix_ms);
}

Result<void> TextureFusion::restore(const SkinTexture& texture) {
  const auto& atlas = *impl_->atlas;
  const bool is_same = texture.atlas && texture.atlas->width_px == atlas.width_px &&
                       texture.atlas->height_px == atlas.height_px &&
                       texture.atlas->corners_px == atlas.corners_px &&
                       texture.atlas->mesh.vertices == atlas.mesh.vertices &&
                       texture.sources.width() == atlas.width_px &&
                       texture.sources.height() == atlas.height_px;
  if (!is_same) {
    return make_error(ErrorCode::kInvalidArgument,
                      "the texture belongs to another skin or another unwrapping of it");
  }
  clear();
  impl_->frames = texture.frames;
  for (std::size_t i = 0; i < impl_->texels.size(); ++i) {
    const auto pixel = impl_->texels[i].pixel;
    const auto& source = texture.sources.data()[pixel];
    if (source.frame == TexelSource::kNeverSeen) continue;
    impl_->states[i] = {.color = to_vector(texture.color.data()[pixel]),
                        .soft = Vector3f::Zero(),
                        .worth = std::max(0.8F * source.px_per_mm, 1e-3F),
                        .sharpness = 1.0F,
                        .source = source};
  }
  impl_->restore_soft_layer();
  return {};
}

void TextureFusion::clear() {
  impl_->states.assign(impl_->texels.size(), {});
  impl_->soft_layer.clear();
  impl_->frames.clear();
  impl_->last_gains = Vector3f::Ones();
  impl_->last_shift_mm.reset();
  impl_->last_seen.reset();
  ++impl_->version;
}

SkinTexture TextureFusion::texture() const {
  const auto& atlas = *impl_->atlas;
  SkinTexture texture{.atlas = impl_->atlas,
                      .color = Image<Rgb8>(atlas.width_px, atlas.height_px, kUnseenColor),
                      .sources = Image<TexelSource>(atlas.width_px, atlas.height_px),
                      .frames = impl_->frames};
  Image<std::uint8_t> is_texel(atlas.width_px, atlas.height_px, 0);
  for (std::size_t i = 0; i < impl_->texels.size(); ++i) {
    const Texel& texel = impl_->texels[i];
    const TexelState& state = impl_->states[i];
    is_texel.data()[texel.pixel] = 1;
    if (state.worth <= 0.0F) continue;
    const auto& corners = atlas.mesh.triangles[texel.triangle];
    const Vector3f soft = impl_->soft_layer.color(corners, texel.share).value_or(state.soft);
    texture.color.data()[texel.pixel] = to_rgb(soft + state.color - state.soft);
    texture.sources.data()[texel.pixel] = state.source;
  }
  internal::fill_gutters(texture.color, std::move(is_texel), kGutterPx);
  return texture;
}

std::size_t TextureFusion::num_frames() const {
  return impl_->frames.size();
}

std::uint64_t TextureFusion::version() const {
  return impl_->version;
}

std::optional<double> TextureFusion::last_shift_mm() const {
  return impl_->last_shift_mm;
}

}  // namespace mor

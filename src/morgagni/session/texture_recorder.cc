// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/session/texture_recorder.h"

#include <chrono>
#include <utility>

#include <sys/resource.h>
#include <unistd.h>

#include "morgagni/core/image_png.h"
#include "morgagni/core/log.h"
#include "morgagni/documentation/skin_atlas.h"
#include "morgagni/documentation/skin_texture_io.h"
#include "morgagni/documentation/texture_coverage.h"
#include "morgagni/documentation/texture_view.h"

namespace mor {
namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kFolder = "texture";
constexpr std::chrono::milliseconds kMeltPeriod{250};
constexpr std::chrono::milliseconds kShowPeriod{1000};
constexpr std::chrono::milliseconds kWakeUp{200};
constexpr int kSideWidthPx = 220;
constexpr int kSideHeightPx = 240;
constexpr int kNiceness = 10;  ///< The picture on the screen goes first.

std::int64_t unix_ms(Clock::time_point when) {
  const auto wall = std::chrono::system_clock::now() - (Clock::now() - when);
  return std::chrono::duration_cast<std::chrono::milliseconds>(wall.time_since_epoch()).count();
}

/// On the skin that the frame shows.
std::optional<double> bound_of(const TrackedFrame& tracked, const TriangleMesh& skin) {
  if (!tracked.covariance) return std::nullopt;
  const Eigen::Vector3d middle = skin.bounds().center().cast<double>();
  const bool has_middle = tracked.skin && tracked.skin->num_seen > 0;
  return error_bound_mm(*tracked.covariance, has_middle ? tracked.skin->seen_center_mm : middle);
}

bool is_same_skin(const TriangleMesh& a, const TriangleMesh& b) {
  return a.vertices == b.vertices && a.triangles == b.triangles;
}

}  // namespace

TextureRecorder::TextureRecorder(std::shared_ptr<const Case> body)
    : body_(std::move(body)), thread_([this](std::stop_token stop) { run(stop); }) {}

TextureRecorder::~TextureRecorder() = default;

void TextureRecorder::look(const TrackedFrame& tracked) {
  {
    const std::lock_guard lock(mutex_);
    if (!status_.is_recording) return;
  }
  const bool is_good = tracked.state == TrackingState::kTracking && tracked.frame &&
                       tracked.ct_from_depth && !tracked.is_held;
  if (is_good) slot_.put(tracked);
}

Result<void> TextureRecorder::record(bool on) {
  const std::lock_guard lock(mutex_);
  if (on && !status_.is_ready) {
    return make_error(ErrorCode::kInvalidArgument,
                      status_.problem.empty() ? "the skin is being unwrapped: try again in a moment"
                                              : status_.problem);
  }
  status_.is_recording = on;
  return {};
}

void TextureRecorder::start_again() {
  {
    const std::lock_guard lock(mutex_);
    wants_again_ = true;
  }
  slot_.put(std::nullopt);
}

Result<void> TextureRecorder::save() {
  {
    const std::lock_guard lock(mutex_);
    if (!texture_ || status_.num_frames == 0 || wants_again_) {
      return make_error(ErrorCode::kInvalidArgument,
                        "there is nothing to save: no skin has been recorded yet");
    }
    wants_save_ = true;
    status_.is_saving = true;
  }
  slot_.put(std::nullopt);
  return {};
}

TextureStatus TextureRecorder::status() const {
  const std::lock_guard lock(mutex_);
  return status_;
}

std::vector<std::byte> TextureRecorder::sides_png() const {
  const std::lock_guard lock(mutex_);
  return sides_png_;
}

std::shared_ptr<const SkinTexture> TextureRecorder::texture() const {
  const std::lock_guard lock(mutex_);
  return texture_;
}

std::optional<TextureFusion> TextureRecorder::begin() {
  const auto fail = [this](const std::string& sentence) {
    log::warn("{}", sentence);
    const std::lock_guard lock(mutex_);
    status_.problem = sentence;
  };
  std::shared_ptr<const SkinAtlas> atlas;
  auto saved = body_->folder.empty()
                   ? Result<SkinTexture>(make_error(ErrorCode::kNotFound, "the case has no folder"))
                   : read_skin_texture(body_->folder / kFolder);
  if (!saved && saved.error().code != ErrorCode::kNotFound) {
    fail("the case's texture cannot be used: " + saved.error().message);
  }
  if (saved && !is_same_skin(saved->atlas->mesh, body_->skin->mesh)) {
    fail("the case's texture was made on another skin: saving a new one replaces it");
    saved = make_error(ErrorCode::kNotFound, "");
  }
  if (saved) {
    atlas = saved->atlas;  // However it was unwrapped.
  } else {
    auto unwrapped = unwrap_skin(body_->skin->mesh);
    if (!unwrapped) {
      fail("the skin cannot be unwrapped: " + unwrapped.error().message);
      return std::nullopt;
    }
    atlas = std::make_shared<const SkinAtlas>(*std::move(unwrapped));
  }
  auto fusion = TextureFusion::create(atlas);
  if (!fusion) {
    fail(fusion.error().message);
    return std::nullopt;
  }
  if (saved) {
    if (const auto restored = fusion->restore(*saved); !restored) fail(restored.error().message);
  }
  coverage_ = std::make_unique<SkinCoverage>(atlas);
  show(*fusion);
  const std::lock_guard lock(mutex_);
  status_.is_ready = true;
  status_.is_saved = saved.has_value();
  return *std::move(fusion);
}

void TextureRecorder::melt(TextureFusion& fusion, const TrackedFrame& tracked) {
  const auto outcome = fusion.add(*tracked.frame,
                                  *tracked.ct_from_depth,
                                  bound_of(tracked, body_->skin->mesh),
                                  unix_ms(tracked.frame->captured_at));
  const std::lock_guard lock(mutex_);
  if (!outcome) {
    status_.problem = outcome.error().message;
    return;
  }
  status_.last = *outcome;
  if (*outcome == FusionOutcome::kFused) status_.is_saved = false;
}

void TextureRecorder::show(const TextureFusion& fusion) {
  auto texture = std::make_shared<const SkinTexture>(fusion.texture());
  const double coverage = coverage_->share(*texture);
  auto png = encode_png(draw_four_sides(*texture, kSideWidthPx, kSideHeightPx).view());
  shown_version_ = fusion.version();
  const std::lock_guard lock(mutex_);
  texture_ = std::move(texture);
  sides_png_ = std::move(png);
  status_.coverage = coverage;
  status_.num_frames = fusion.num_frames();
  status_.version = shown_version_ + 1;  // 0: there is none yet.
}

void TextureRecorder::write() {
  const auto saved = body_->folder.empty()
                         ? make_error(ErrorCode::kInvalidArgument,
                                      "this case was not loaded from a folder: nowhere to save")
                         : write_skin_texture(body_->folder / kFolder, *texture());
  if (!saved) log::warn("the texture cannot be saved: {}", saved.error().message);
  const std::lock_guard lock(mutex_);
  status_.is_saving = false;
  status_.is_saved = saved.has_value();
  status_.problem = saved ? "" : "the texture cannot be saved: " + saved.error().message;
}

void TextureRecorder::run(std::stop_token stop) {
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNiceness);
  auto fusion = begin();
  auto next_show = Clock::now();
  while (fusion && !stop.stop_requested()) {
    const auto arrived = slot_.take(stop, kWakeUp);
    const auto [again, save] = [this] {
      const std::lock_guard lock(mutex_);
      return std::pair{std::exchange(wants_again_, false), std::exchange(wants_save_, false)};
    }();
    const auto begun = Clock::now();
    const bool has_frame = arrived && *arrived;
    if (has_frame && !again) melt(*fusion, **arrived);
    const auto show_if = [&](bool is_due) {
      if (!is_due || fusion->version() == shown_version_) return;
      show(*fusion);
      next_show = Clock::now() + kShowPeriod;
    };
    show_if(save || begun >= next_show);
    // First: whoever saves and then begins again wants what was there kept.
    if (save) write();
    if (again) {
      fusion->clear();
      {
        const std::lock_guard lock(mutex_);
        status_.last.reset();
        status_.is_saved = false;
      }
      show_if(true);
    }
    // Frames come faster than they are wanted.
    if (!has_frame) continue;
    std::unique_lock lock(mutex_);
    std::condition_variable_any().wait_until(
        lock, stop, begun + kMeltPeriod, [this] { return wants_again_ || wants_save_; });
  }
}

}  // namespace mor

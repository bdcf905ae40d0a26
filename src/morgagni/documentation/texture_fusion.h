// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include <Eigen/Geometry>

#include "morgagni/camera/range_camera.h"
#include "morgagni/core/result.h"
#include "morgagni/documentation/skin_texture.h"

namespace mor {

struct TextureFusionOptions {
  double max_bound_mm = 6.0;    ///< Frames whose pose is less sure are passed over. > 0.
  double max_motion_px = 12.0;  ///< And those that moved more since the frame before. > 0.
  double max_view_angle_rad =
      1.2;  ///< Between the skin's normal and the way to the camera. (0, 1.5].
  double clutter_margin_mm = 14.0;  ///< Around what stands before the skin nothing is taken. >= 0.
  bool aligns_frames = true;  ///< Moves each frame a little to where it fits the texture so far.

  [[nodiscard]] Result<void> check() const;
};

/// What became of a frame.
enum class FusionOutcome : std::uint8_t {
  kFused,       ///< It has given texels.
  kNothingNew,  ///< All that it sees has been seen better.
  kUncertain,   ///< Its pose is not sure enough.
  kMoving,      ///< The camera moved too fast.
  kNoSkin,      ///< It sees no skin that it could give.
  kMisfit,      ///< It does not fit what the texture shows already.
  kFull,        ///< The texture has as many frames as it can keep.
};

/// "fused", "nothing new", "uncertain", "moving", "no skin", "misfit", "full".
[[nodiscard]] std::string_view to_string(FusionOutcome outcome);

/// Melts tracked frames into one texture of the skin.
///
/// Each frame is compared with the CT's skin at its pose: it gives the texels that its colour
/// camera sees and whose depth reading lies on the skin. A texel's detail comes from the one frame
/// that shows it best (nearest, most squarely, sharpest, most surely placed); what is wider than
/// about a centimetre comes from all frames, brought to one exposure and white balance, so that
/// neither seams nor shadows stay. Frames are aligned on the detail that is there before they are
/// melted. docs/fused-texture.md says how, and how well.
/// @threads None of its own; one call at a time.
class TextureFusion {
 public:
  /// @errors kInvalidArgument: bad options or atlas, a skin without normals.
  [[nodiscard]] static Result<TextureFusion> create(std::shared_ptr<const SkinAtlas> atlas,
                                                    const TextureFusionOptions& options = {});
  TextureFusion(TextureFusion&&) noexcept;
  TextureFusion& operator=(TextureFusion&&) noexcept;
  ~TextureFusion();

  /// Takes what is good of a frame.
  /// @param ct_from_depth  Its pose. @param bound_mm  Error bound on the skin it shows; none: not
  ///        known, and the frame is passed over.
  /// @param captured_unix_ms  Wall clock, for the provenance.
  /// @errors kInvalidArgument: a frame without calibration, or with pictures of other sizes than it
  ///         says.
  /// @cost About 30 ms for a frame of 640x480 and a skin of 40,000 triangles.
  [[nodiscard]] Result<FusionOutcome> add(const RgbdFrame& frame,
                                          const Eigen::Isometry3d& ct_from_depth,
                                          std::optional<double> bound_mm,
                                          std::int64_t captured_unix_ms);

  /// Goes on from a texture of the same atlas. @errors kInvalidArgument: of another one.
  [[nodiscard]] Result<void> restore(const SkinTexture& texture);

  /// Forgets everything.
  void clear();

  /// The texture so far. What was never seen is grey, and has no source. @cost About 20 ms.
  [[nodiscard]] SkinTexture texture() const;

  [[nodiscard]] std::size_t num_frames() const;
  /// Counts every frame that has changed the texture, restoring and forgetting too.
  [[nodiscard]] std::uint64_t version() const;
  /// How far the last frame was moved to fit, mm at the skin it shows. None: it was not.
  [[nodiscard]] std::optional<double> last_shift_mm() const;

 private:
  struct Impl;
  explicit TextureFusion(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace mor

// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "morgagni/core/image.h"
#include "morgagni/core/result.h"
#include "morgagni/ct/cut_part.h"
#include "morgagni/ct/surfaces.h"
#include "morgagni/geometry/triangle_mesh.h"
#include "morgagni/geometry/volume.h"

namespace mor {

namespace internal {
struct BareCt;
}

enum class BodyPlane : std::uint8_t { kAxial, kCoronal, kSagittal };

/// A part that people may decide about.
struct BodyPart {
  CutPart what;
  bool stands_out = false;  ///< Found as part of the body; else found as its surroundings.
  bool is_kept = false;     ///< As it is taken now.
  Rgb8 color;               ///< Of it in the slices.
};

/// What would be taken for the body, to be looked at and corrected before a case is made of it.
/// Works on every second voxel of a fine CT, so that it follows a slider.
class BodyCheck {
 public:
  explicit BodyCheck(std::shared_ptr<const Volume> volume);
  ~BodyCheck();
  BodyCheck(const BodyCheck&) = delete;
  BodyCheck& operator=(const BodyCheck&) = delete;

  /// Finds the body anew. Marks that hit nothing at these thresholds are passed over.
  /// @errors As extract_skin(); what was found before stays then.
  /// @cost 0.2 s of CPU for 512x512x275, as long as the constructor when `take_off_mm` changes.
  [[nodiscard]] Result<void> find(const SkinOptions& options);

  /// Of 1 ml and more; what is cut first, then what stands out, the largest first.
  [[nodiscard]] const std::vector<BodyPart>& parts() const;
  /// Whether a mark names this part.
  [[nodiscard]] bool holds(std::size_t part, const Eigen::Vector3d& mark_mm) const;
  [[nodiscard]] double body_ml() const;
  /// Where the skin is not certain, the largest stretch first.
  [[nodiscard]] const std::vector<SkinDoubt>& doubts() const;

  /// The CT's size across a plane's picture, to the right and down, and through it.
  [[nodiscard]] Eigen::Vector3d size_mm(BodyPlane plane) const;
  /// The slice that a place lies in, as slice() counts them. @param place_mm  Frame ct.
  [[nodiscard]] double position(BodyPlane plane, const Eigen::Vector3d& place_mm) const;
  /// One slice as radiologists hang it: the patient's right, or front, is on the left. The skin has
  /// a green outline, orange where it is not certain; cut parts have their colours.
  /// @param position  0..1: feet to head, front to back, right to left.
  /// @param height_px 16..2048; the width follows.
  [[nodiscard]] Image<Rgb8> slice(BodyPlane plane, double position, int height_px) const;

  /// To be turned and looked at, not measured: frame ct, LPS mm, without normals.
  [[nodiscard]] TriangleMesh skin() const;
  /// The triangles of skin() that are not certain.
  [[nodiscard]] TriangleMesh doubtful_skin() const;
  /// One of parts(), whether it is kept or not.
  [[nodiscard]] TriangleMesh part_surface(std::size_t part) const;

 private:
  struct Found;
  std::shared_ptr<const Volume> volume_;
  Volume coarse_;
  std::unique_ptr<const internal::BareCt> bare_;  ///< `coarse_` without covers.
  std::vector<Eigen::Vector3d> taken_off_mm_;     ///< And without the layers there.
  std::unique_ptr<const Found> found_;
};

}  // namespace mor

// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

#include "morgagni/registration/automatic_start.h"
#include "morgagni/registration/internal/field_registration.h"
#include "morgagni/registration/internal/start_finding.h"
#include "morgagni/registration/internal/start_picture.h"
#include "morgagni/registration/internal/start_refinement.h"
#include "morgagni/registration/internal/start_scene.h"
#include "morgagni/registration/internal/start_search.h"
#include "morgagni/registration/internal/start_verification.h"
#include "morgagni/registration/internal/start_views.h"
#include "morgagni/registration/internal/start_volume.h"

namespace mor::internal {

inline constexpr float kLookToleranceMm = 1.0F;
/// Of the extent: poses that put the body this near to one another are one.
inline constexpr double kSameShare = 0.08;

/// How far evened readings may lie from the skin, where a single one's noise is `noise_mm`.
[[nodiscard]] RefinementRound close_round(float noise_mm);

/// How many hypotheses of a plane are followed.
struct SearchEffort {
  std::size_t max_searched = 0;  ///< Glanced at.
  std::size_t max_refined = 0;   ///< Of those, refined.
  std::size_t max_verified = 0;  ///< Of those, looked at pixel by pixel.
};

inline constexpr SearchEffort kFirstEffort{
    .max_searched = 100, .max_refined = 20, .max_verified = 6};

/// The automatic start's steps, one after the other, on the caller's TBB arena.
class StartFinder {
 public:
  StartFinder(std::shared_ptr<const FixedSurface> fixed,
              const PinholeCamera& depth_camera,
              const AutomaticStartOptions& options);

  /// In one picture.
  [[nodiscard]] Result<AutomaticStartResult> find(ImageView<const std::uint16_t> depth_mm,
                                                  const std::stop_token& stop) const;
  /// In the next one of several. The wide search, which takes most of the time, is left to the
  /// third and every second one after it: what the narrow one finds there may settle it first.
  [[nodiscard]] Result<AutomaticStartResult> find_next(ImageView<const std::uint16_t> depth_mm,
                                                       StartRecall& recall,
                                                       const std::stop_token& stop) const;

 private:
  /// The body's volumes for one side that it may lie on.
  struct Lying {
    StartVolume coarse;
    StartVolume fine;
  };

  /// What the searches in one picture have found.
  struct Findings {
    std::vector<StartFinding> here;      ///< By this picture alone, best first.
    std::vector<StartFinding> together;  ///< By all pictures, best first; empty for the first.

    [[nodiscard]] const std::vector<StartFinding>& judged() const {
      return together.empty() ? here : together;
    }
  };

  /// Of a reading where the pose puts the body.
  [[nodiscard]] float noise_at(const Eigen::Isometry3d& ct_from_depth) const;
  [[nodiscard]] std::vector<StartPlane> planes_of(const StartPicture& picture) const;
  /// Takes the picture in; what was found before is moved to where the camera is now.
  void take_in(ImageView<const std::uint16_t> depth_mm, StartRecall& recall) const;
  /// The best poses on all planes of the newest picture, each verified.
  [[nodiscard]] Result<Findings> find_all(const StartRecall& recall,
                                          bool searches_wide,
                                          const std::stop_token& stop) const;
  [[nodiscard]] bool settles_alone(const StartRecall& recall,
                                   const std::vector<StartFinding>& here) const;
  [[nodiscard]] Result<AutomaticStartResult> decide(const StartRecall& recall,
                                                    const std::vector<StartFinding>& findings,
                                                    const std::stop_token& stop) const;
  /// What the pictures say of the best of these poses together, best first.
  [[nodiscard]] std::vector<StartFinding> judge_together(const SeenViews& views,
                                                         std::vector<StartFinding> findings) const;
  [[nodiscard]] Eigen::Isometry3d laid_down(const StartFinding& finding) const;
  [[nodiscard]] Eigen::Isometry3d about_center(const Eigen::Vector3d& shift_mm,
                                               double turn_rad,
                                               const Eigen::Vector3d& up_ct) const;
  [[nodiscard]] std::vector<StartFinding> places_around(const StartPicture& picture,
                                                        const StartFinding& finding) const;
  void search_around(const StartPicture& picture,
                     const std::vector<StartPlane>& planes,
                     const SensorPoints& points,
                     std::size_t count,
                     std::vector<StartFinding>& findings) const;
  [[nodiscard]] std::vector<StartFinding> judge_around(const SeenViews& views,
                                                       std::vector<StartFinding> findings) const;
  void refine_together(const SeenViews& views,
                       const PointCloud& standing,
                       const SensorPoints& readings,
                       StartFinding& finding) const;
  [[nodiscard]] SkinAgreement glance_at(const SeenViews& views,
                                        const Eigen::Isometry3d& ct_from_depth) const;
  [[nodiscard]] SkinAgreement look_at(const SeenViews& views,
                                      StartPicture SeenView::*kind,
                                      const Eigen::Isometry3d& ct_from_depth) const;
  [[nodiscard]] Result<double> mirrored_share(const SeenViews& views,
                                              const StartFinding& finding,
                                              const std::stop_token& stop) const;

  [[nodiscard]] Result<std::vector<StartFinding>> find_on(
      const StartPicture& picture,
      const std::vector<StartPlane>& planes,
      const std::shared_ptr<const StartScene>& scene,
      const SearchEffort& effort,
      const std::stop_token& stop) const;
  [[nodiscard]] std::vector<StartPlane> tables_not_seen(
      const StartPicture& picture, const std::vector<StartPlane>& planes) const;
  [[nodiscard]] Result<void> find_on_each(const StartPicture& picture,
                                          const std::vector<StartPlane>& seen_planes,
                                          const std::vector<StartPlane>& planes,
                                          const SearchEffort& effort,
                                          std::vector<StartFinding>& findings,
                                          const std::stop_token& stop) const;
  [[nodiscard]] std::vector<StartFinding> search(const StartPicture& picture,
                                                 const StartScene& scene,
                                                 const Lying& lying,
                                                 const SearchEffort& effort) const;
  void refine(const StartPicture& picture,
              const StartScene& scene,
              std::vector<StartFinding>& findings,
              const std::stop_token& stop) const;
  [[nodiscard]] Eigen::Isometry3d straight_from_plane(const StartScene& scene,
                                                      const Eigen::Isometry3d& on_plane,
                                                      const Eigen::Vector3d& up_ct) const;
  void verify(const StartPicture& picture,
              const std::vector<StartPlane>& planes,
              std::vector<StartFinding>& findings,
              const std::stop_token& stop) const;
  void sharpen(const StartPicture& picture,
               const std::vector<StartPlane>& planes,
               std::vector<StartFinding>& findings,
               const std::stop_token& stop) const;
  AutomaticStartOptions options_;
  StartPictureMaker maker_;
  std::shared_ptr<const FixedSurface> fixed_;
  std::vector<Lying> lyings_;
  float extent_mm_;         ///< The body's largest side.
  float height_mm_ = 0.0F;  ///< How high it may lie.
  StartVerifier verifier_;
  FieldRegistration fine_;
  Eigen::AlignedBox3d bounds_;
};

}  // namespace mor::internal

// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "morgagni/casefile/case.h"
#include "morgagni/documentation/finding_book.h"
#include "morgagni/documentation/geodesic.h"
#include "morgagni/render/pick.h"
#include "morgagni/session/finding_marks.h"
#include "morgagni/session/live_loop.h"

namespace mor {

/// A point that was tapped, and what is known of it.
struct FindingPick {
  int number = 0;  ///< Counts from 1.
  FindingPoint point;
  PickedPoint seen;
  ShownPicture shown;  ///< The picture that was tapped.
};

/// Where findings are made: takes taps on the live picture and keeps the case's book.
/// @threads marks() comes from the render thread, everything else from one other thread.
class FindingsDesk {
 public:
  /// The book lies in the case's folder `findings`. Where it cannot be read, every call says why.
  FindingsDesk(std::shared_ptr<const Case> body, std::shared_ptr<const LiveLoop> loop);

  /// LiveLoop::Mark.
  [[nodiscard]] std::string marks(const ShownPicture& shown);

  /// What lies under a pixel of a picture that was shown a moment ago.
  ///
  /// On the skin, the bound of the pose is divided by the cosine at which the skin is seen: that
  /// far an error across the picture carries along the skin.
  /// @param frame_id  Of that picture. None: the newest.
  /// @errors kInvalidArgument: that picture is gone, no pose of its own, no body, or something in
  ///         front of it at this pixel.
  [[nodiscard]] Result<FindingPick> pick(const Eigen::Vector2d& pixel,
                                         std::optional<std::uint64_t> frame_id);
  /// Forgets the picks that are not in a finding.
  void forget_picks();

  /// Makes a finding of picks. @errors kInvalidArgument: a pick that is not there, points that do
  /// not fit the kind, or as FindingBook::add().
  [[nodiscard]] Result<Finding> add(FindingKind kind,
                                    const std::vector<int>& picks,
                                    const std::string& note);
  [[nodiscard]] Result<void> set_note(const std::string& id, const std::string& note);
  [[nodiscard]] Result<void> remove(const std::string& id);
  [[nodiscard]] Result<void> undo();

  /// @errors Why the case's findings cannot be read.
  [[nodiscard]] Result<std::vector<Finding>> findings() const;
  [[nodiscard]] std::string undoable() const;
  /// PNG. @errors kInvalidArgument: there is none; kIo.
  [[nodiscard]] Result<std::vector<std::byte>> photo(const std::string& id, bool overlay) const;

 private:
  [[nodiscard]] Result<ShownPicture> shown_picture(std::optional<std::uint64_t> frame_id) const;
  [[nodiscard]] Result<std::vector<FindingPick>> picks_of(const std::vector<int>& numbers) const;
  [[nodiscard]] Result<void> measure(Finding& finding);
  [[nodiscard]] FindingPhotos photos_of(const std::vector<FindingPick>& picks) const;
  void show_marks();
  /// After a change of the book that may have failed.
  [[nodiscard]] Result<void> changed(const Result<void>& change);

  std::shared_ptr<const Case> body_;
  std::shared_ptr<const LiveLoop> loop_;
  RenderScene scene_;
  Result<FindingBook> book_;
  std::optional<GeodesicMesh> ways_;  ///< Made when it is first needed.
  std::vector<FindingPick> picks_;
  int last_pick_ = 0;
  FindingMarks marks_;

  mutable std::mutex mutex_;
  std::deque<ShownPicture> shown_;  ///< The last ones, newest at the back.
};

}  // namespace mor

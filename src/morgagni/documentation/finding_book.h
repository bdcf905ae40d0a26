// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "morgagni/core/folder_lock.h"
#include "morgagni/core/result.h"
#include "morgagni/documentation/finding.h"

namespace mor {

/// How long the straight way between two places is, and how sure that is: their bounds added as
/// independent errors, sqrt(a^2 + b^2). None: one of them is not known.
struct MeasuredLength {
  double length_mm = 0.0;
  std::optional<double> bound_mm;
};
[[nodiscard]] MeasuredLength straight_length(const FindingPoint& from, const FindingPoint& to);
[[nodiscard]] std::optional<double> length_bound_mm(const FindingPoint& from,
                                                    const FindingPoint& to);

/// A picture that goes with a finding.
struct FindingPhotos {
  std::vector<std::byte> plain;    ///< PNG: what the camera saw. Empty: none.
  std::vector<std::byte> overlay;  ///< PNG: the same place as it was shown. Empty: none.
};

/// The name of the second photo of a finding whose first has the name `photo`.
[[nodiscard]] std::string overlay_photo_name(const std::string& photo);

/// The findings of a case, kept on disk at each change (findings_io.h).
///
/// What is deleted can be had back by undo() as long as the book lives; photos are never deleted.
/// Only one book at a time writes into a folder: the first change takes it, until the book is gone.
/// @threads One call at a time.
class FindingBook {
 public:
  /// A folder that is not there is made with the first finding. @errors As read_findings().
  [[nodiscard]] static Result<FindingBook> open(const std::filesystem::path& folder);

  [[nodiscard]] const std::vector<Finding>& findings() const { return findings_; }
  [[nodiscard]] const Finding* find(const std::string& id) const;

  /// Gives the finding its id, its time and its photo's name. @return It, as it is kept.
  /// @errors As check_finding() and write_findings(); kInvalidArgument: another program writes
  /// here.
  [[nodiscard]] Result<Finding> add(Finding finding, const FindingPhotos& photos);
  /// @errors kInvalidArgument: there is no such finding, or as check_note().
  [[nodiscard]] Result<void> set_note(const std::string& id, const std::string& note);
  [[nodiscard]] Result<void> remove(const std::string& id);

  /// Takes the last change back. @errors kInvalidArgument: there is none.
  [[nodiscard]] Result<void> undo();
  /// What undo() would take back, in words: "the new note of F3". Empty: nothing.
  [[nodiscard]] std::string undoable() const;

 private:
  struct Change {
    std::string words;
    std::vector<Finding> before;
  };

  explicit FindingBook(std::filesystem::path folder) : folder_(std::move(folder)) {}
  [[nodiscard]] Result<void> take_folder();
  [[nodiscard]] Result<void> change(std::string words, std::vector<Finding> after);

  std::filesystem::path folder_;
  std::vector<Finding> findings_;
  std::vector<Change> changes_;
  std::optional<FolderLock> lock_;
};

}  // namespace mor

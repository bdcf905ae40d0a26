// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/documentation/finding_book.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "morgagni/core/files.h"
#include "morgagni/core/utc.h"
#include "morgagni/documentation/findings_io.h"

namespace mor {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxUndo = 50;

tl::unexpected<Error> no_such(const std::string& id) {
  const bool is_id = finding_number(id).has_value();
  return make_error(ErrorCode::kInvalidArgument,
                    is_id ? fmt::format("there is no finding {}", id) : "there is no such finding");
}

}  // namespace

std::optional<double> length_bound_mm(const FindingPoint& from, const FindingPoint& to) {
  if (!from.bound_mm || !to.bound_mm) return std::nullopt;
  return std::hypot(*from.bound_mm, *to.bound_mm);
}

MeasuredLength straight_length(const FindingPoint& from, const FindingPoint& to) {
  return {(to.ct_mm - from.ct_mm).norm(), length_bound_mm(from, to)};
}

std::string overlay_photo_name(const std::string& photo) {
  return fs::path(photo).stem().string() + "_overlay" + fs::path(photo).extension().string();
}

Result<FindingBook> FindingBook::open(const fs::path& folder) {
  FindingBook book(folder);
  MOR_TRY(book.findings_, read_findings(folder));
  return book;
}

const Finding* FindingBook::find(const std::string& id) const {
  const auto found = std::find_if(
      findings_.begin(), findings_.end(), [&](const Finding& each) { return each.id == id; });
  return found == findings_.end() ? nullptr : &*found;
}

Result<Finding> FindingBook::add(Finding finding, const FindingPhotos& photos) {
  MOR_CHECK(take_folder());
  if (findings_.size() >= kMaxFindings) {
    return make_error(
        ErrorCode::kInvalidArgument,
        fmt::format("a case takes up to {} findings: this one is full", kMaxFindings));
  }
  MOR_TRY(const int last, last_finding_number(folder_));
  finding.id = fmt::format("F{}", last + 1);
  finding.created_at = utc_text();
  finding.photo = photos.plain.empty() ? "" : finding.id + ".png";
  MOR_CHECK(check_finding(finding));
  if (!photos.plain.empty()) MOR_CHECK(write_file(folder_ / finding.photo, photos.plain));
  if (!photos.plain.empty() && !photos.overlay.empty())
    MOR_CHECK(write_file(folder_ / overlay_photo_name(finding.photo), photos.overlay));
  auto after = findings_;
  after.push_back(finding);
  MOR_CHECK(change(finding.id, std::move(after)));
  return finding;
}

Result<void> FindingBook::set_note(const std::string& id, const std::string& note) {
  MOR_CHECK(take_folder());
  MOR_CHECK(check_note(note));
  const Finding* const found = find(id);
  if (found == nullptr) return no_such(id);
  if (found->note == note) return {};
  auto after = findings_;
  after[static_cast<std::size_t>(found - findings_.data())].note = note;
  return change("the new note of " + id, std::move(after));
}

Result<void> FindingBook::remove(const std::string& id) {
  MOR_CHECK(take_folder());
  if (find(id) == nullptr) return no_such(id);
  auto after = findings_;
  std::erase_if(after, [&](const Finding& each) { return each.id == id; });
  return change("the deletion of " + id, std::move(after));
}

Result<void> FindingBook::undo() {
  if (changes_.empty()) {
    return make_error(ErrorCode::kInvalidArgument, "there is nothing to undo");
  }
  MOR_CHECK(write_findings(folder_, changes_.back().before));
  findings_ = std::move(changes_.back().before);
  changes_.pop_back();
  return {};
}

std::string FindingBook::undoable() const {
  return changes_.empty() ? std::string() : changes_.back().words;
}

Result<void> FindingBook::take_folder() {
  if (lock_) return {};
  MOR_TRY(
      auto lock,
      FolderLock::make_and_take(folder_,
                                FolderLock::Kind::kExclusive,
                                "another Morgagni writes the findings of this case: stop that one "
                                "first"));
  // Another book may have written since this one was opened.
  MOR_TRY(findings_, read_findings(folder_));
  lock_ = std::move(lock);
  return {};
}

Result<void> FindingBook::change(std::string words, std::vector<Finding> after) {
  MOR_CHECK(write_findings(folder_, after));
  changes_.push_back({std::move(words), std::exchange(findings_, std::move(after))});
  if (changes_.size() > kMaxUndo) changes_.erase(changes_.begin());
  return {};
}

}  // namespace mor

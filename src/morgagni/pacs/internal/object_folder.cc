// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/pacs/internal/object_folder.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

#include <fcntl.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

#include "morgagni/pacs/internal/part10.h"

namespace mor::internal {
namespace {

namespace fs = std::filesystem;

/// How often the disk's room is looked at.
constexpr std::uint64_t kCheckBytes = 64ULL << 20U;

tl::unexpected<Error> cannot_write(const fs::path& path) {
  return make_error(ErrorCode::kIo,
                    fmt::format("{}: cannot be written: {}", path.string(), std::strerror(errno)));
}

}  // namespace

ObjectFolder::ObjectFolder(fs::path folder,
                           const std::vector<std::string>& wanted,
                           const PacsOptions& options,
                           OnObject on_object)
    : folder_(std::move(folder)),
      part_(folder_ / fmt::format("{}.part", ::getpid())),
      wanted_(wanted.begin(), wanted.end()),
      max_object_bytes_(options.max_object_bytes),
      min_free_bytes_(options.min_free_bytes),
      on_object_(std::move(on_object)) {}

ObjectFolder::~ObjectFolder() {
  if (fd_ < 0) return;
  close();
  ::unlink(part_.c_str());
}

void ObjectFolder::close() {
  ::close(fd_);
  fd_ = -1;
}

Result<void> ObjectFolder::check_room() const {
  std::error_code status;
  const auto space = fs::space(folder_, status);
  if (!status && space.available >= min_free_bytes_) return {};
  return make_error(
      ErrorCode::kInvalidArgument,
      status ? fmt::format("{}: {}", folder_.string(), status.message())
             : fmt::format("{}: {} MB of disk are left, {} MB are kept free (--min-free-mb)",
                           folder_.string(),
                           space.available / 1000000,
                           min_free_bytes_ / 1000000));
}

Result<void> ObjectFolder::begin() {
  MOR_CHECK(check_room());
  if (fd_ >= 0) close();
  fd_ = ::open(part_.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0644);
  if (fd_ < 0) return cannot_write(part_);
  num_bytes_ = 0;
  checked_at_ = 0;
  head_.clear();
  return {};
}

Result<void> ObjectFolder::append(std::string_view bytes) {
  num_bytes_ += bytes.size();
  if (num_bytes_ > max_object_bytes_) {
    return make_error(ErrorCode::kInvalidArgument,
                      fmt::format("the PACS sends an object of more than {} MB, the limit "
                                  "(--max-object-mb)",
                                  max_object_bytes_ / 1000000));
  }
  if (num_bytes_ - checked_at_ > kCheckBytes) {
    MOR_CHECK(check_room());
    checked_at_ = num_bytes_;
  }
  if (head_.size() < kPart10HeadBytes)
    head_ += bytes.substr(0, std::min(bytes.size(), kPart10HeadBytes - head_.size()));
  while (!bytes.empty()) {
    const auto count = ::write(fd_, bytes.data(), bytes.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return cannot_write(part_);
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  return {};
}

Result<void> ObjectFolder::end() {
  MOR_TRY(const auto uid, part10_uid(head_));
  const auto found = wanted_.find(uid);
  if (found == wanted_.end()) {
    return make_error(ErrorCode::kIo,
                      "the PACS sends " + uid + ", which was not asked for, or twice");
  }
  wanted_.erase(found);
  close();
  const auto file = folder_ / (uid + ".dcm");
  if (::rename(part_.c_str(), file.c_str()) != 0) return cannot_write(file);
  if (on_object_) on_object_(file, num_bytes_);
  return {};
}

}  // namespace mor::internal

// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "study_files.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zip.h>

#include "dicom_file.h"
#include "inflate.h"
#include "messages.h"
#include "sandbox.h"

namespace mor::import {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxFiles = 20000;
constexpr std::size_t kPreambleBytes = 128;

tl::unexpected<Error> too_many_files(const fs::path& path) {
  return make_error(ErrorCode::kInvalidArgument,
                    path.string() + " holds more than " + std::to_string(kMaxFiles) +
                        " files: give the folder of one series");
}

class DiskFiles : public StudyFiles {
 public:
  explicit DiskFiles(std::vector<fs::path> paths) : paths_(std::move(paths)) {}
  std::size_t size() const override { return paths_.size(); }
  std::string name(std::size_t index) const override { return paths_[index].string(); }
  Result<FileBytes> load(std::size_t index) const override { return map_file(paths_[index]); }

 private:
  std::vector<fs::path> paths_;
};

Result<std::vector<fs::path>> files_below(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry :
       fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied)) {
    if (!entry.is_regular_file()) continue;
    files.push_back(entry.path());
    if (files.size() > kMaxFiles) return too_many_files(folder);
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// A record's path, "CT\STUDY1\IM0001": names below the DICOMDIR's folder, never above it. Media
/// carry it in capitals; a copy on a disk may not.
std::optional<fs::path> referenced_file(const fs::path& folder, const std::string& id) {
  fs::path path = folder;
  for (std::size_t start = 0; start <= id.size();) {
    const auto end = std::min(id.find('\\', start), id.size());
    std::string word = id.substr(start, end - start);
    start = end + 1;
    if (word.empty() || word == "." || word == ".." || word.find('/') != std::string::npos)
      return std::nullopt;
    std::error_code failure;
    if (!fs::exists(path / word, failure)) {
      std::transform(word.begin(), word.end(), word.begin(), [](unsigned char letter) {
        return static_cast<char>(std::tolower(letter));
      });
    }
    path /= word;
  }
  std::error_code failure;
  if (!fs::is_regular_file(path, failure)) return std::nullopt;
  return path;
}

Result<std::unique_ptr<StudyFiles>> open_directory_file(const fs::path& path,
                                                        const DicomElement& records) {
  std::vector<fs::path> files;
  std::vector<std::string> missing;
  for (const auto& record : records.items) {
    const std::string id = record.text(Tag::kReferencedFileId);
    if (id.empty()) continue;
    if (auto file = referenced_file(path.parent_path(), id)) {
      files.push_back(*std::move(file));
    } else {
      missing.push_back(id);
    }
    if (files.size() > kMaxFiles) return too_many_files(path);
  }
  if (!missing.empty())
    say_note(path.string() + " names files that are missing: " + some_of(missing));
  if (files.empty()) {
    return make_error(ErrorCode::kIo,
                      path.string() +
                          " names no file that is there: copy the whole medium, or give the folder "
                          "with the slices");
  }
  std::sort(files.begin(), files.end());
  return std::make_unique<DiskFiles>(std::move(files));
}

class ZipFiles : public StudyFiles {
 public:
  ZipFiles(fs::path path, zip_t* archive)
      : path_(std::move(path)), archive_(archive, zip_discard) {}

  Result<void> list() {
    std::error_code failure;
    const std::uintmax_t archive_bytes = fs::file_size(path_, failure);
    const auto num_entries = ::zip_get_num_entries(archive_.get(), 0);
    if (num_entries > static_cast<zip_int64_t>(kMaxFiles)) return too_many_files(path_);
    for (zip_int64_t i = 0; i < num_entries; ++i) {
      zip_stat_t info{};
      if (::zip_stat_index(archive_.get(), static_cast<zip_uint64_t>(i), 0, &info) != 0) continue;
      constexpr zip_uint64_t kNeeded = ZIP_STAT_NAME | ZIP_STAT_SIZE | ZIP_STAT_COMP_SIZE;
      if ((info.valid & kNeeded) != kNeeded || std::string_view(info.name).ends_with('/')) continue;
      if ((info.valid & ZIP_STAT_ENCRYPTION_METHOD) != 0 && info.encryption_method != ZIP_EM_NONE) {
        return make_error(ErrorCode::kUnsupported,
                          path_.string() + " is encrypted: unpack it first and give the folder");
      }
      if (info.comp_size > archive_bytes) {
        return make_error(ErrorCode::kIo,
                          path_.string() + " is cut short or damaged: it says that it holds " +
                              std::to_string(info.comp_size) + " bytes of one file, and has " +
                              std::to_string(archive_bytes));
      }
      entries_.push_back({static_cast<zip_uint64_t>(i), info.name, info.size, info.comp_size});
    }
    std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) {
      return a.name < b.name;
    });
    return {};
  }

  std::size_t size() const override { return entries_.size(); }
  std::string name(std::size_t index) const override {
    return path_.filename().string() + ":" + entries_[index].name;
  }
  Result<FileBytes> load(std::size_t index) const override {
    const Entry& entry = entries_[index];
    if (entry.size > max_inflated_bytes(entry.compressed)) {
      return make_error(ErrorCode::kInvalidArgument,
                        "would inflate from " + std::to_string(entry.compressed) + " to " +
                            std::to_string(entry.size) + " bytes: it is no picture");
    }
    const auto damaged = make_error(ErrorCode::kIo, "is cut short or damaged");
    const std::unique_ptr<zip_file_t, int (*)(zip_file_t*)> file(
        ::zip_fopen_index(archive_.get(), entry.index, 0), ::zip_fclose);
    if (!file) return damaged;
    allow_memory(entry.size);
    const auto bytes = std::make_shared<std::vector<std::byte>>(entry.size);
    std::uint64_t done = 0;
    while (done < entry.size) {
      const auto got = ::zip_fread(file.get(), bytes->data() + done, entry.size - done);
      if (got <= 0) return damaged;
      done += static_cast<std::uint64_t>(got);
    }
    // One byte more makes the library compare the checksum.
    std::byte beyond{};
    if (::zip_fread(file.get(), &beyond, 1) != 0) return damaged;
    return FileBytes{bytes, *bytes};
  }

 private:
  struct Entry {
    zip_uint64_t index;
    std::string name;
    std::uint64_t size;
    std::uint64_t compressed;
  };

  fs::path path_;
  std::unique_ptr<zip_t, void (*)(zip_t*)> archive_;
  std::vector<Entry> entries_;
};

Result<std::unique_ptr<StudyFiles>> open_zip(const fs::path& path) {
  int failure = 0;
  zip_t* archive = ::zip_open(path.c_str(), ZIP_RDONLY, &failure);
  if (archive == nullptr) {
    return make_error(ErrorCode::kIo,
                      path.string() + " is cut short or damaged: it is no whole zip archive");
  }
  auto files = std::make_unique<ZipFiles>(path, archive);
  MOR_CHECK(files->list());
  return files;
}

std::string start_of(const fs::path& path) {
  std::array<char, kPreambleBytes + 4> start{};
  std::ifstream file(path, std::ios::binary);
  file.read(start.data(), start.size());
  return {start.data(), static_cast<std::size_t>(file.gcount())};
}

bool is_zip(std::string_view start) {
  return start.starts_with(std::string_view("PK\x03\x04", 4)) ||
         start.starts_with(std::string_view("PK\x05\x06", 4));
}

bool is_dicom(std::string_view start) {
  return start.size() == kPreambleBytes + 4 && start.substr(kPreambleBytes) == "DICM";
}

}  // namespace

Result<FileBytes> map_file(const fs::path& path) {
  const auto unreadable = make_error(ErrorCode::kIo, "cannot be read: check that you may read it");
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return unreadable;
  struct stat info {};
  const bool known = ::fstat(fd, &info) == 0;
  const auto size = static_cast<std::size_t>(info.st_size);
  if (known && size == 0) {
    ::close(fd);
    return FileBytes{};
  }
  void* data = known ? ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, fd, 0) : MAP_FAILED;
  ::close(fd);
  if (data == MAP_FAILED) return unreadable;
  std::shared_ptr<const void> owner(data, [size](void* start) { ::munmap(start, size); });
  return FileBytes{std::move(owner), {static_cast<const std::byte*>(data), size}};
}

bool is_study_file(const fs::path& path) {
  const std::string start = start_of(path);
  return is_zip(start) || is_dicom(start);
}

Result<std::unique_ptr<StudyFiles>> open_study(const fs::path& path) {
  if (fs::is_directory(path)) {
    MOR_TRY(auto files, files_below(path));
    return std::make_unique<DiskFiles>(std::move(files));
  }
  if (is_zip(start_of(path))) return open_zip(path);
  MOR_TRY(const auto mapped, map_file(path));
  const auto parsed = parse_dicom(mapped.bytes);
  const auto* records = parsed ? parsed->data.find(Tag::kDirectoryRecords) : nullptr;
  if (records != nullptr) return open_directory_file(path, *records);
  return std::make_unique<DiskFiles>(std::vector<fs::path>{path});
}

}  // namespace mor::import

// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "image_heads.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <span>
#include <sstream>
#include <system_error>
#include <vector>

#include <zlib.h>

namespace mor::import {
namespace {

namespace fs = std::filesystem;

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char letter) {
    return static_cast<char>(std::tolower(letter));
  });
  return text;
}

using GzipFile = std::unique_ptr<gzFile_s, int (*)(gzFile)>;

/// zlib reads files that are not compressed as they are.
GzipFile open_gzip(const fs::path& path) {
  return {::gzopen(path.c_str(), "rb"), ::gzclose};
}

/// The first bytes of a NIfTI file, either version in either byte order.
class NiftiHead {
 public:
  explicit NiftiHead(const fs::path& path) : bytes_(kMostBytes, '\0') {
    const auto file = open_gzip(path);
    const int got = file ? ::gzread(file.get(), bytes_.data(), kMostBytes) : 0;
    bytes_.resize(static_cast<std::size_t>(std::max(got, 0)));
    is_swapped_ = number<std::int32_t>(0) != 348 && number<std::int32_t>(0) != 540;
    version_ = number<std::int32_t>(0) == 348 ? 1 : number<std::int32_t>(0) == 540 ? 2 : 0;
  }

  /// Without the magic it would be an ANALYZE file, which says nothing about left and right.
  [[nodiscard]] bool is_sound() const {
    if (version_ == 1) return says(344, "n+1") || says(344, "ni1");
    return version_ == 2 && (says(4, "n+2") || says(4, "ni2"));
  }
  [[nodiscard]] std::uintmax_t bits_per_voxel() const {
    const auto bits = number<std::int16_t>(version_ == 1 ? 72 : 14);
    return static_cast<std::uintmax_t>(std::max<std::int16_t>(bits, 0));
  }
  [[nodiscard]] std::uintmax_t voxels_start() const {
    constexpr double kFarthest = 1e9;
    const double start = version_ == 1 ? static_cast<double>(number<float>(108))
                                       : static_cast<double>(number<std::int64_t>(168));
    return start >= 0.0 && start < kFarthest ? static_cast<std::uintmax_t>(start) : 0;
  }
  /// Of the two ways to say where the grid lies those that are in use.
  [[nodiscard]] bool has_possible_place() const {
    if (version_ == 1) {
      return (number<std::int16_t>(252) <= 0 || are_possible<float>(256, 6)) &&
             (number<std::int16_t>(254) <= 0 || are_possible<float>(280, 12));
    }
    return (number<std::int32_t>(344) <= 0 || are_possible<double>(352, 6)) &&
           (number<std::int32_t>(348) <= 0 || are_possible<double>(400, 12));
  }

 private:
  static constexpr unsigned kMostBytes = 540;
  static constexpr double kFarthestMm = 1e7;

  template <class T>
  [[nodiscard]] T number(std::size_t at) const {
    std::array<char, sizeof(T)> stored{};
    if (at + sizeof(T) > bytes_.size()) return T{};
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(at), sizeof(T), stored.begin());
    if (is_swapped_) std::reverse(stored.begin(), stored.end());
    return std::bit_cast<T>(stored);
  }
  template <class T>
  [[nodiscard]] bool are_possible(std::size_t at, std::size_t count) const {
    for (std::size_t i = 0; i < count; ++i)
      if (!(std::abs(number<T>(at + i * sizeof(T))) < kFarthestMm)) return false;
    return true;
  }
  [[nodiscard]] bool says(std::size_t at, std::string_view magic) const {
    return at + magic.size() <= bytes_.size() &&
           std::string_view(bytes_).substr(at, magic.size()) == magic;
  }

  std::string bytes_;
  bool is_swapped_ = false;
  int version_ = 0;
};

Result<void> check_nifti_head(const fs::path& path) {
  const NiftiHead head(path);
  if (!head.is_sound()) {
    return make_error(ErrorCode::kIo,
                      path.filename().string() +
                          " is no NIfTI file: its head is damaged, or of an older "
                          "format that does not tell left from right");
  }
  // VNL never ends with some of these, and ends the whole process over others.
  if (head.has_possible_place()) return {};
  return make_error(ErrorCode::kIo,
                    path.filename().string() +
                        " is damaged: its qform or sform, which says where the voxels lie, has a "
                        "number that is not below 1e7");
}

/// All of it is read through once.
Result<void> check_nifti_length(const fs::path& path, std::uintmax_t num_voxels) {
  const NiftiHead head(path);
  const auto num_wanted = num_voxels * head.bits_per_voxel() / 8 + head.voxels_start();
  const auto file = open_gzip(path);
  std::vector<char> bytes(std::size_t{1} << 20);
  std::uintmax_t num_bytes = 0;
  while (file) {
    const int got = ::gzread(file.get(), bytes.data(), static_cast<unsigned>(bytes.size()));
    if (got <= 0) break;
    num_bytes += static_cast<std::uintmax_t>(got);
  }
  int failure = Z_OK;
  if (file) ::gzerror(file.get(), &failure);
  if (file && failure == Z_OK && num_bytes >= num_wanted) return {};
  return make_error(ErrorCode::kIo,
                    path.filename().string() +
                        " is cut short or damaged: " + std::to_string(num_wanted) +
                        " bytes are announced, " + std::to_string(num_bytes) + " can be read");
}

Result<void> refuse_dimensions(const fs::path& path, long num_dimensions) {
  return make_error(ErrorCode::kUnsupported,
                    path.filename().string() + " has " + std::to_string(num_dimensions) +
                        " dimensions, a CT has 3: give a volume");
}

/// Teem ends the whole process over a NRRD of many dimensions.
Result<void> check_nrrd_head(const fs::path& path) {
  constexpr int kMaxLines = 200;
  constexpr std::string_view kKey = "dimension:";
  std::ifstream file(path, std::ios::binary);
  std::string line;
  for (int i = 0; i < kMaxLines && std::getline(file, line) && !line.empty(); ++i) {
    if (!line.starts_with(kKey)) continue;
    const long num_dimensions = std::strtol(line.c_str() + kKey.size(), nullptr, 10);
    if (num_dimensions >= 2 && num_dimensions <= 4) return {};
    return refuse_dimensions(path, num_dimensions);
  }
  return {};
}

/// A MetaImage's lines "Key = Value" up to the one that names where the voxels are.
struct MetaHead {
  struct Line {
    std::string key;
    std::vector<std::string> words;
  };
  std::vector<Line> lines;
  std::uintmax_t num_bytes = 0;
  bool is_whole = false;

  [[nodiscard]] std::string first_word(std::string_view key) const {
    for (const auto& line : lines)
      if (line.key == key) return line.words.front();
    return {};
  }
};

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream in(text);
  return {std::istream_iterator<std::string>(in), {}};
}

MetaHead read_meta_head(const fs::path& path) {
  constexpr std::size_t kMostBytes = 1U << 16U;
  constexpr std::size_t kLongestLine = 499;  // Behind it MetaIO never ends.
  std::string text(kMostBytes, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  MetaHead head;
  for (std::size_t start = 0; start < text.size();) {
    const auto end = std::min(text.find('\n', start), text.size());
    const std::string line = text.substr(start, end - start);
    start = end + 1;
    if (words_of(line).empty()) continue;
    const auto separator = line.find_first_of("=:");
    const auto key = words_of(line.substr(0, separator));
    const auto words =
        words_of(separator == std::string::npos ? std::string() : line.substr(separator + 1));
    if (key.size() != 1 || words.empty() || line.size() > kLongestLine) return head;
    head.lines.push_back({key.front(), words});
    head.num_bytes = std::min(start, text.size());
    head.is_whole = key.front() == "ElementDataFile";
    if (head.is_whole) return head;
  }
  return head;
}

bool is_number(const std::string& word) {
  if (word.find_first_not_of("0123456789+-.eE") != std::string::npos) return false;
  char* end = nullptr;
  const double number = std::strtod(word.c_str(), &end);
  constexpr double kMost = 1e15;
  return *end == '\0' && std::abs(number) <= kMost;
}

/// How many numbers a key needs; none where it has no numbers.
std::size_t num_numbers(const std::string& key, std::size_t num_dimensions) {
  constexpr std::array<std::string_view, 9> kOne = {"NDims",
                                                    "ID",
                                                    "ParentID",
                                                    "HeaderSize",
                                                    "CompressedDataSize",
                                                    "ElementMin",
                                                    "ElementMax",
                                                    "ElementNumberOfChannels",
                                                    "ElementNBits"};
  constexpr std::array<std::string_view, 9> kVector = {"DimSize",
                                                       "Offset",
                                                       "Position",
                                                       "Origin",
                                                       "CenterOfRotation",
                                                       "ElementSpacing",
                                                       "ElementSize",
                                                       "ImagePosition",
                                                       "SequenceID"};
  constexpr std::array<std::string_view, 3> kMatrix = {
      "TransformMatrix", "Orientation", "Rotation"};
  const auto is_among = [&](const auto& keys) {
    return std::find(keys.begin(), keys.end(), key) != keys.end();
  };
  if (is_among(kOne) || key.starts_with("ElementToIntensityFunction")) return 1;
  if (is_among(kVector)) return num_dimensions;
  if (is_among(kMatrix)) return num_dimensions * num_dimensions;
  return key == "Color" ? 4 : 0;
}

/// MetaIO never ends with a head in which a number is missing or none.
Result<void> check_meta_head(const fs::path& path) {
  const std::string name = path.filename().string();
  const MetaHead head = read_meta_head(path);
  const long num_dimensions = std::strtol(head.first_word("NDims").c_str(), nullptr, 10);
  for (const auto& line : head.lines) {
    if (line.key == "NDims" && (num_dimensions < 1 || num_dimensions > 4))
      return refuse_dimensions(path, num_dimensions);
    const std::size_t needed = num_numbers(line.key, static_cast<std::size_t>(num_dimensions));
    const auto words = std::span(line.words).first(std::min(needed, line.words.size()));
    if (words.size() < needed || !std::all_of(words.begin(), words.end(), is_number)) {
      return make_error(ErrorCode::kIo,
                        name + " is damaged: behind its " + line.key + " stands no row of " +
                            std::to_string(needed) + " finite number(s)");
    }
  }
  if (head.is_whole) return {};
  return make_error(ErrorCode::kIo,
                    name +
                        " is damaged or not what its name says: its head has no line that says "
                        "where the voxels are (ElementDataFile)");
}

Result<void> check_meta_length(const fs::path& path, std::uintmax_t num_bytes) {
  const MetaHead head = read_meta_head(path);
  if (lower_case(head.first_word("CompressedData")) == "true") {
    const std::string packed = head.first_word("CompressedDataSize");
    num_bytes = std::strtoull(packed.c_str(), nullptr, 10);
  }
  const std::string data_file = head.first_word("ElementDataFile");
  if (data_file == "LIST" || data_file.find('%') != std::string::npos) return {};
  std::error_code failure;
  std::uintmax_t left = 0;
  if (data_file == "LOCAL") {
    left = fs::file_size(path, failure) - head.num_bytes;
  } else {
    left = fs::file_size(path.parent_path() / data_file, failure);
  }
  if (!failure && left >= num_bytes) return {};
  return make_error(ErrorCode::kIo,
                    path.filename().string() + " is cut short: " + std::to_string(num_bytes) +
                        " bytes of voxels are announced, " + std::to_string(failure ? 0 : left) +
                        " are there");
}

}  // namespace

ImageFormat image_format_of(const fs::path& path) {
  const std::string name = lower_case(path.filename().string());
  const auto is_any = [&](std::string_view a, std::string_view b) {
    return name.ends_with(a) || name.ends_with(b);
  };
  if (is_any(".nii", ".nii.gz")) return ImageFormat::kNifti;
  if (is_any(".nrrd", ".nhdr")) return ImageFormat::kNrrd;
  if (is_any(".mha", ".mhd")) return ImageFormat::kMetaImage;
  return ImageFormat::kNone;
}

Result<void> check_head(const fs::path& path, ImageFormat format) {
  switch (format) {
    case ImageFormat::kNifti:
      return check_nifti_head(path);
    case ImageFormat::kNrrd:
      return check_nrrd_head(path);
    case ImageFormat::kMetaImage:
      return check_meta_head(path);
    case ImageFormat::kNone:
      break;
  }
  return {};
}

std::uintmax_t bytes_for_voxels(const fs::path& path) {
  const std::string ending = lower_case(path.extension().string());
  std::error_code failure;
  const auto own = fs::file_size(path, failure);
  if (failure) return 0;
  if (ending != ".mhd" && ending != ".nhdr") return own;
  constexpr int kMaxFiles = 20000;
  int num_files = 0;
  std::uintmax_t all = 0;
  const auto folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  for (fs::directory_iterator it(folder, failure), end; !failure && it != end;
       it.increment(failure)) {
    if (++num_files > kMaxFiles) break;
    std::error_code no_file;
    const auto bytes = fs::file_size(it->path(), no_file);
    if (!no_file) all += bytes;
  }
  return all;
}

Result<void> check_length(const fs::path& path,
                          ImageFormat format,
                          std::uintmax_t num_voxels,
                          std::uintmax_t num_bytes) {
  if (format == ImageFormat::kNifti) return check_nifti_length(path, num_voxels);
  if (format == ImageFormat::kMetaImage) return check_meta_length(path, num_bytes);
  return {};
}

}  // namespace mor::import

// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// From disk to a ready case at full size: times, memory, and the longest that progress stood still.
//
//   prepare_whole CHEST FOLDER
//
// CHEST holds the 138 slices of the data folder's chest CT, unpacked. FOLDER/ct gets 275 of 1 mm,
// if it is not there yet: between every two their mean, written as DICOM files like theirs. They
// are interpolated, not measured; a real series of that size holds more noise.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <sys/resource.h>
#include <time.h>

#include "morgagni/casefile/prepare.h"
#include "morgagni/core/kept_memory.h"
#include "morgagni/core/log.h"

namespace mor {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kPixelBytes = 512 * 512 * 2;

struct SliceFile {
  std::string bytes;
  std::size_t place_at = 0;  ///< Of the text of Image Position (Patient).
  std::size_t place_length = 0;
  double height_mm = 0.0;

  [[nodiscard]] std::size_t pixels_at() const { return bytes.size() - kPixelBytes; }
};

/// An implicit little-endian file whose pixels end it, as those of the data folder are.
SliceFile read_slice(const fs::path& path) {
  SliceFile slice;
  std::ifstream file(path, std::ios::binary);
  slice.bytes.assign(std::istreambuf_iterator<char>(file), {});
  const auto tag_at = slice.bytes.find(std::string("\x20\0\x32\0", 4), 132);
  if (tag_at == std::string::npos || slice.bytes.size() < kPixelBytes) return {};
  std::memcpy(&slice.place_length, slice.bytes.data() + tag_at + 4, 4);
  slice.place_at = tag_at + 8;
  const std::string place = slice.bytes.substr(slice.place_at, slice.place_length);
  slice.height_mm = std::atof(place.substr(place.rfind('\\') + 1).c_str());
  return slice;
}

SliceFile between(const SliceFile& low, const SliceFile& high) {
  SliceFile middle = low;
  for (std::size_t i = 0; i < kPixelBytes; i += 2) {
    std::uint16_t a = 0;
    std::uint16_t b = 0;
    std::memcpy(&a, low.bytes.data() + low.pixels_at() + i, 2);
    std::memcpy(&b, high.bytes.data() + high.pixels_at() + i, 2);
    const auto mean = static_cast<std::uint16_t>((a + b) / 2);
    std::memcpy(middle.bytes.data() + middle.pixels_at() + i, &mean, 2);
  }
  std::string place = low.bytes.substr(low.place_at, low.place_length);
  place = place.substr(0, place.rfind('\\') + 1) +
          std::to_string(0.5 * (low.height_mm + high.height_mm));
  place.resize(low.place_length, ' ');
  middle.bytes.replace(low.place_at, low.place_length, place);
  // Its own SOP Instance UID, of the same length.
  for (std::size_t at = 0;
       (at = middle.bytes.find(std::string("\x08\0\x18\0", 4), at)) != std::string::npos;
       ++at) {
    std::uint32_t length = 0;
    std::memcpy(&length, middle.bytes.data() + at + 4, 4);
    if (length < 16 || length > 64) continue;
    char& digit = middle.bytes[at + 8 + length - 2];
    digit = digit == '9' ? '8' : '9';
    break;
  }
  return middle;
}

void make_dense(const fs::path& from, const fs::path& to) {
  std::vector<SliceFile> slices;
  for (const auto& entry : fs::directory_iterator(from))
    if (auto slice = read_slice(entry.path()); slice.place_at > 0)
      slices.push_back(std::move(slice));
  std::sort(slices.begin(), slices.end(), [](const SliceFile& a, const SliceFile& b) {
    return a.height_mm < b.height_mm;
  });
  fs::create_directories(to);
  int number = 0;
  const auto write = [&](const SliceFile& slice) {
    std::ofstream(to / (std::to_string(1000 + number++) + ".dcm"), std::ios::binary) << slice.bytes;
  };
  for (std::size_t k = 0; k < slices.size(); ++k) {
    write(slices[k]);
    if (k + 1 < slices.size()) write(between(slices[k], slices[k + 1]));
  }
}

struct Watch {
  Clock::time_point last = Clock::now();
  std::string stage = "start";
  double longest_s = 0.0;
  std::string where;

  void move(std::string_view now, double fraction) {
    const auto time = Clock::now();
    const double gap_s = std::chrono::duration<double>(time - last).count();
    char text[96];
    std::snprintf(text,
                  sizeof(text),
                  "%s -> %.*s %.2f",
                  stage.c_str(),
                  static_cast<int>(now.size()),
                  now.data(),
                  fraction);
    if (gap_s > 0.3) std::printf("  %.2f s: %s\n", gap_s, text);
    if (gap_s > longest_s) where = text;
    longest_s = std::max(longest_s, gap_s);
    last = time;
    std::snprintf(
        text, sizeof(text), "%.*s %.2f", static_cast<int>(now.size()), now.data(), fraction);
    stage = text;
  }
};

double cpu_s(const rusage& used) {
  return static_cast<double>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

int run(const fs::path& chest, const fs::path& folder) {
  if (!fs::exists(folder / "ct")) make_dense(chest, folder / "ct");
  Watch watch;
  const auto started = Clock::now();
  const auto summary = prepare_case(
      folder / "ct", folder / "case", {}, [&](std::string_view stage, double fraction) {
        watch.move(stage, fraction);
      });
  const double wall_s = std::chrono::duration<double>(Clock::now() - started).count();
  if (!summary) {
    std::fprintf(stderr, "%s\n", summary.error().message.c_str());
    return 1;
  }
  rusage own{};
  rusage import{};
  ::getrusage(RUSAGE_SELF, &own);
  ::getrusage(RUSAGE_CHILDREN, &import);
  std::printf(
      "%.2f s of wall time (read %.2f), %.2f s of processor time (import process %.2f); peak %.0f "
      "MB "
      "and import process %.0f MB; progress stood still for at most %.2f s (%s)\n",
      wall_s,
      summary->reading_seconds,
      cpu_s(own) + cpu_s(import),
      cpu_s(import),
      static_cast<double>(own.ru_maxrss) / 1e3,
      static_cast<double>(import.ru_maxrss) / 1e3,
      watch.longest_s,
      watch.where.c_str());
  return 0;
}

}  // namespace
}  // namespace mor

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: prepare_whole CHEST FOLDER\n", stderr);
    return 2;
  }
  mor::log::set_up(false);
  mor::keep_freed_memory();  // As `morgagni prepare` does.
  return mor::run(argv[1], argv[2]);
}

// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "dicom_segmentation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "dicom_file.h"
#include "dicom_slice.h"
#include "messages.h"
#include "sandbox.h"
#include "study_files.h"

namespace mor::import {
namespace {

namespace fs = std::filesystem;

struct Frame {
  DicomSlice place;
  int segment = 0;
  int layer = 0;  ///< Of the grid.
};

struct Segmentation {
  std::string name;
  FileBytes bytes;
  DicomFile file;
  std::vector<Frame> frames;
  int bits = 1;          ///< A pixel.
  int least_stored = 1;  ///< From which a pixel belongs to its segment.
  std::span<const std::byte> pixels;
};

tl::unexpected<Error> refuse(ErrorCode code, const Segmentation& what, const std::string& why) {
  return make_error(code, what.name + " " + why);
}

/// The one DICOM file of modality SEG.
Result<Segmentation> find_segmentation(const fs::path& path) {
  MOR_TRY(const auto files, open_study(path));
  std::optional<Segmentation> found;
  for (std::size_t i = 0; i < files->size(); ++i) {
    say_file(files->name(i));
    MOR_TRY(auto bytes, files->load(i));
    auto file = parse_dicom(bytes.bytes);
    if (!file && file.error().code == ErrorCode::kUnsupported) continue;
    if (!file) return make_error(file.error().code, files->name(i) + " " + file.error().message);
    if (file->data.text(Tag::kModality) != "SEG") continue;
    if (found) {
      return make_error(ErrorCode::kUnsupported,
                        path.string() + " holds several segmentations (" + found->name + ", " +
                            files->name(i) + "): name one file");
    }
    found.emplace();
    found->name = files->name(i);
    found->bytes = std::move(bytes);
    found->file = *std::move(file);
  }
  if (found) return *std::move(found);
  return make_error(ErrorCode::kUnsupported,
                    path.string() + " holds no DICOM segmentation (modality SEG)");
}

/// How a pixel is stored, and where the pixels are.
Result<void> take_pixels(Segmentation& seg) {
  const auto& data = seg.file.data;
  const std::string type = data.text(Tag::kSegmentationType);
  seg.bits = data.uint16(Tag::kBitsAllocated).value_or(0);
  const bool is_read =
      (type == "BINARY" && seg.bits == 1) || (type == "FRACTIONAL" && seg.bits == 8);
  if (!is_read) {
    return refuse(ErrorCode::kUnsupported,
                  seg,
                  "is a segmentation of type \"" + type + "\" with " + std::to_string(seg.bits) +
                      " bits a pixel; BINARY with 1 and FRACTIONAL with 8 are read");
  }
  if (data.big_endian) return refuse(ErrorCode::kUnsupported, seg, "is stored big endian");
  if (seg.file.is_encapsulated)
    return refuse(ErrorCode::kUnsupported, seg, "has compressed pixels: store it without");
  // Half of the largest share or probability decides.
  if (seg.bits == 8) seg.least_stored = (data.uint16(Tag::kMaxFraction).value_or(255) + 1) / 2;
  const auto* element = data.find(Tag::kPixelData);
  if (element == nullptr) return refuse(ErrorCode::kUnsupported, seg, "has no pixels");
  seg.pixels = element->value;
  return {};
}

Result<void> take_frames(Segmentation& seg) {
  const auto places = slices_of(seg.file, 0, seg.name);
  const auto* groups = seg.file.data.find(Tag::kFrameGroups);
  if (groups == nullptr || groups->items.size() != places.size() || places.empty())
    return refuse(ErrorCode::kUnsupported, seg, "does not say of each frame where it lies");
  for (std::size_t i = 0; i < places.size(); ++i) {
    const auto& place = places[i];
    const auto* which = groups->items[i].item(Tag::kSegmentIdentification);
    const int segment = which == nullptr ? 0 : which->uint16(Tag::kReferencedSegment).value_or(0);
    if (!place.position_mm || !place.axes || !(place.spacing_mm.minCoeff() > 0.0) ||
        place.columns < 1 || place.rows < 1)
      return refuse(ErrorCode::kUnsupported, seg, "does not say of each frame where it lies");
    if (segment < 1 || segment > 32767) {
      return refuse(ErrorCode::kInvalidArgument,
                    seg,
                    "names segment " + std::to_string(segment) + " in frame " +
                        std::to_string(i + 1) + ", segments count from 1 to 32767");
    }
    seg.frames.push_back({place, segment});
  }
  const std::size_t num_bits = static_cast<std::size_t>(places[0].columns) *
                               static_cast<std::size_t>(places[0].rows) * places.size() *
                               static_cast<std::size_t>(seg.bits);
  if (seg.pixels.size() >= (num_bits + 7) / 8) return {};
  return refuse(ErrorCode::kIo,
                seg,
                "is cut short: " + std::to_string((num_bits + 7) / 8) +
                    " bytes of pixels are announced, " + std::to_string(seg.pixels.size()) +
                    " are there");
}

/// Heights of the frames along their normal, each once, rising.
Result<std::vector<double>> heights_of(const Segmentation& seg) {
  constexpr double kSame = 1e-2;
  const auto& first = seg.frames[0].place;
  std::vector<double> heights;
  for (const auto& frame : seg.frames) {
    const Eigen::Vector3d way = *frame.place.position_mm - *first.position_mm;
    const double height = way.dot(first.normal());
    const bool is_parallel = (*frame.place.axes - *first.axes).cwiseAbs().maxCoeff() < 1e-3;
    if (!is_parallel ||
        (way - height * first.normal()).norm() > 0.1 * first.spacing_mm.minCoeff()) {
      return refuse(ErrorCode::kInvalidArgument,
                    seg,
                    "has frames that are not stacked at right angles: resample it");
    }
    heights.push_back(height);
  }
  std::sort(heights.begin(), heights.end());
  heights.erase(std::unique(heights.begin(),
                            heights.end(),
                            [](double a, double b) { return std::abs(a - b) < kSame; }),
                heights.end());
  return heights;
}

/// How thick frames are that all lie at one height, as far as that is said.
double thickness_mm(const Segmentation& seg) {
  for (const auto* groups : {seg.file.data.item(Tag::kSharedGroups),
                             &seg.file.data.find(Tag::kFrameGroups)->items.front()}) {
    const auto* measures = groups == nullptr ? nullptr : groups->item(Tag::kPixelMeasures);
    if (measures == nullptr) continue;
    const auto said = measures->numbers(Tag::kSliceThickness);
    if (said.size() == 1 && said[0] > 0.0) return said[0];
  }
  return seg.frames[0].place.spacing_mm.minCoeff();
}

/// Puts each frame on a layer of an even grid.
Result<ImportHeader> make_grid(Segmentation& seg) {
  MOR_TRY(const auto heights, heights_of(seg));
  const auto& first = seg.frames[0].place;
  double step_mm = heights.size() > 1 ? heights[1] - heights[0] : thickness_mm(seg);
  for (std::size_t i = 2; i < heights.size(); ++i)
    step_mm = std::min(step_mm, heights[i] - heights[i - 1]);
  // A volume has two layers or more: above a single one there is an empty one.
  const double num_layers =
      std::max(2.0, std::round((heights.back() - heights[0]) / step_mm) + 1.0);
  if (!(num_layers <= kMaxVolumeSide) || std::max(first.columns, first.rows) > kMaxVolumeSide ||
      2.0 * num_layers * first.columns * first.rows > static_cast<double>(kMaxVolumeBytes)) {
    return refuse(ErrorCode::kInvalidArgument,
                  seg,
                  "would have " + std::to_string(first.columns) + " x " +
                      std::to_string(first.rows) + " x " + std::to_string(num_layers) +
                      " voxels, the limit is " + std::to_string(kMaxVolumeSide) + " a side");
  }
  for (auto& frame : seg.frames) {
    const double height =
        (*frame.place.position_mm - *first.position_mm).dot(first.normal()) - heights[0];
    const double layer = std::round(height / step_mm);
    if (std::abs(height - layer * step_mm) > 0.2 * step_mm)
      return refuse(ErrorCode::kInvalidArgument, seg, "has frames that are not evenly apart");
    frame.layer = static_cast<int>(layer);
  }
  ImportHeader header{};
  header.magic = kImportMagic;
  header.size = {first.columns, first.rows, static_cast<int>(num_layers), 0};
  header.spacing_mm = {first.spacing_mm.x(), first.spacing_mm.y(), step_mm};
  const Eigen::Vector3d origin = *first.position_mm + heights[0] * first.normal();
  for (int i = 0; i < 3; ++i) {
    header.origin_mm[static_cast<std::size_t>(i)] = origin[i];
    for (int column = 0; column < 3; ++column)
      header.axes[static_cast<std::size_t>(3 * column + i)] =
          column < 2 ? (*first.axes)(i, column) : first.normal()[i];
  }
  set_description(header, "segmentation");
  return header;
}

void fill(const Segmentation& seg, const ImportHeader& header, std::span<std::int16_t> labels) {
  const std::size_t frame_pixels =
      static_cast<std::size_t>(header.size[0]) * static_cast<std::size_t>(header.size[1]);
  std::size_t num_overlapping = 0;
  for (std::size_t i = 0; i < seg.frames.size(); ++i) {
    const auto& frame = seg.frames[i];
    const auto layer =
        labels.subspan(static_cast<std::size_t>(frame.layer) * frame_pixels, frame_pixels);
    for (std::size_t pixel = 0; pixel < frame_pixels; ++pixel) {
      const std::size_t at = i * frame_pixels + pixel;
      // Bits follow each other without gaps between frames, the lowest of a byte first.
      const int stored = seg.bits == 8 ? std::to_integer<int>(seg.pixels[at])
                                       : std::to_integer<int>(seg.pixels[at / 8]) >> (at % 8) & 1;
      if (stored < seg.least_stored) continue;
      if (layer[pixel] != 0) ++num_overlapping;
      layer[pixel] = static_cast<std::int16_t>(frame.segment);
    }
  }
  if (num_overlapping > 0) {
    say_note("segments overlap in " + std::to_string(num_overlapping) +
             " voxels: there the later one counts");
  }
}

/// "Recommended Display CIELab Value" (PS3.3 C.10.7.1.1) to sRGB, by way of XYZ under D50.
std::array<double, 3> color_of(const DicomDataSet& segment) {
  std::array<double, 3> lab{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto stored = segment.uint16_at(Tag::kSegmentColor, i);
    if (!stored) return {0.8, 0.7, 0.5};
    lab[i] = *stored / 65535.0 * (i == 0 ? 100.0 : 255.0) - (i == 0 ? 0.0 : 128.0);
  }
  const auto inverse = [](double t) {
    constexpr double kEdge = 6.0 / 29.0;
    return t > kEdge ? t * t * t : 3.0 * kEdge * kEdge * (t - 4.0 / 29.0);
  };
  const double fy = (lab[0] + 16.0) / 116.0;
  const Eigen::Vector3d xyz(
      0.9642 * inverse(fy + lab[1] / 500.0), inverse(fy), 0.8249 * inverse(fy - lab[2] / 200.0));
  Eigen::Matrix3d rgb_from_xyz;  // Lindbloom, sRGB adapted to D50 (Bradford).
  rgb_from_xyz << 3.1338561, -1.6168667, -0.4906146, -0.9787684, 1.9161415, 0.0334540, 0.0719453,
      -0.2289914, 1.4052427;
  const Eigen::Vector3d linear = rgb_from_xyz * xyz;
  std::array<double, 3> rgb{};
  for (int i = 0; i < 3; ++i) {
    const double value = std::clamp(linear[i], 0.0, 1.0);
    rgb[static_cast<std::size_t>(i)] =
        value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1.0 / 2.4) - 0.055;
  }
  return rgb;
}

void say_segments(const DicomDataSet& data) {
  const auto* segments = data.find(Tag::kSegments);
  if (segments == nullptr) return;
  for (const auto& segment : segments->items) {
    const int number = segment.uint16(Tag::kSegmentNumber).value_or(0);
    const std::string name = segment.text(Tag::kSegmentLabel);
    if (number > 0 && !name.empty()) say_label(number, color_of(segment), name);
  }
}

}  // namespace

Result<void> import_dicom_segmentation(const fs::path& path) {
  MOR_TRY(Segmentation seg, find_segmentation(path));
  MOR_CHECK(take_pixels(seg));
  MOR_CHECK(take_frames(seg));
  say_progress(0.3);
  MOR_TRY(const ImportHeader header, make_grid(seg));
  MOR_TRY(const auto labels, open_voxels(header));
  allow_memory(labels.size_bytes());
  fill(seg, header, labels);
  say_segments(seg.file.data);
  return {};
}

}  // namespace mor::import

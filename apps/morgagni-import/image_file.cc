// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "image_file.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include <itkImage.h>
#include <itkImageFileReader.h>
#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

namespace mor::import {
namespace {

using FloatImage = itk::Image<float, 3>;

bool ends_with(const std::string& text, std::string_view end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

/// The reader that the file's name asks for; none for other names.
itk::ImageIOBase::Pointer make_image_io(const std::filesystem::path& path) {
  std::string name = path.filename().string();
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char letter) {
    return static_cast<char>(std::tolower(letter));
  });
  if (ends_with(name, ".nii") || ends_with(name, ".nii.gz"))
    return itk::NiftiImageIO::New().GetPointer();
  if (ends_with(name, ".nrrd") || ends_with(name, ".nhdr"))
    return itk::NrrdImageIO::New().GetPointer();
  if (ends_with(name, ".mha") || ends_with(name, ".mhd"))
    return itk::MetaImageIO::New().GetPointer();
  return nullptr;
}

Result<void> check_kind(const itk::ImageIOBase& io, const std::string& name) {
  const unsigned num_dimensions = io.GetNumberOfDimensions();
  for (unsigned axis = 3; axis < num_dimensions; ++axis) {
    if (io.GetDimensions(axis) > 1) {
      return make_error(ErrorCode::kUnsupported,
                        name + " has " + std::to_string(num_dimensions) +
                            " dimensions, a CT has 3: extract one volume of it first");
    }
  }
  if (num_dimensions < 3) {
    return make_error(ErrorCode::kUnsupported,
                      name + " has " + std::to_string(num_dimensions) +
                          " dimensions, a CT has 3: give a volume, not a single picture");
  }
  if (io.GetNumberOfComponents() != 1) {
    return make_error(ErrorCode::kUnsupported,
                      name + " has " + std::to_string(io.GetNumberOfComponents()) +
                          " values a voxel, a CT has one: colour and vector images are not read");
  }
  return {};
}

/// Sides, spacing, origin and axes as the file has them: the parent judges them too, but a side
/// that is out of its limit must not be allocated here.
Result<ImportHeader> header_of(const itk::ImageIOBase& io, const std::string& name) {
  ImportHeader header;
  header.magic = kImportMagic;
  std::int64_t num_bytes = sizeof(std::int16_t);
  for (unsigned axis = 0; axis < 3; ++axis) {
    const auto side = io.GetDimensions(axis);
    if (side > static_cast<itk::SizeValueType>(kMaxVolumeSide)) {
      return make_error(ErrorCode::kInvalidArgument,
                        name + " has " + std::to_string(side) + " voxels along one side, at most " +
                            std::to_string(kMaxVolumeSide) + " are read");
    }
    num_bytes *= static_cast<std::int64_t>(side);
    header.size[axis] = static_cast<std::int32_t>(side);
    header.spacing_mm[axis] = io.GetSpacing(axis);
    header.origin_mm[axis] = io.GetOrigin(axis);
    const auto direction = io.GetDirection(axis);
    for (unsigned row = 0; row < 3; ++row) header.axes[axis * 3 + row] = direction[row];
  }
  if (num_bytes > kMaxVolumeBytes) {
    return make_error(ErrorCode::kInvalidArgument,
                      name + " takes " + std::to_string(num_bytes >> 20) + " MiB, the limit is " +
                          std::to_string(kMaxVolumeBytes >> 20) + " MiB");
  }
  set_description(header, name);
  return header;
}

Result<std::vector<std::int16_t>> hu_of(const FloatImage& image, const std::string& name) {
  const std::size_t num_voxels = image.GetLargestPossibleRegion().GetNumberOfPixels();
  const float* values = image.GetBufferPointer();
  std::vector<std::int16_t> hu(num_voxels);
  for (std::size_t i = 0; i < num_voxels; ++i) {
    if (!std::isfinite(values[i])) {
      return make_error(ErrorCode::kInvalidArgument,
                        name + " has a voxel that is not a number (voxel " + std::to_string(i) +
                            "): replace such voxels with -1024");
    }
    hu[i] = static_cast<std::int16_t>(std::lround(std::clamp(values[i], -32768.0F, 32767.0F)));
  }
  return hu;
}

}  // namespace

Result<ImportedVolume> read_image_file(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  const auto io = make_image_io(path);
  if (!io) {
    return make_error(ErrorCode::kUnsupported,
                      name +
                          " is no CT that is read here: give a DICOM folder, or a .nii, .nii.gz, "
                          ".nrrd, .nhdr, .mha or .mhd file");
  }
  say_file(path.string());
  if (!io->CanReadFile(path.c_str()))
    return make_error(ErrorCode::kIo, name + " is damaged or not what its name says");
  try {
    io->SetFileName(path.string());
    io->ReadImageInformation();
    MOR_CHECK(check_kind(*io, name));
    ImportedVolume volume;
    MOR_TRY(volume.header, header_of(*io, name));
    say_progress(0.05);
    const auto reader = itk::ImageFileReader<FloatImage>::New();
    reader->SetImageIO(io);
    reader->SetFileName(path.string());
    reader->Update();
    say_progress(0.7);
    MOR_TRY(volume.hu, hu_of(*reader->GetOutput(), name));
    return volume;
  } catch (const itk::ExceptionObject& failure) {
    return make_error(ErrorCode::kIo,
                      name + " cannot be read, it may be cut short: " + failure.GetDescription());
  }
}

}  // namespace mor::import

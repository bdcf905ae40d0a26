// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "image_file.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>
#include <string>
#include <system_error>

#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>

#include "image_heads.h"
#include "inflate.h"
#include "label_names.h"
#include "messages.h"
#include "sandbox.h"

namespace mor::import {
namespace {

itk::ImageIOBase::Pointer make_image_io(ImageFormat format) {
  switch (format) {
    case ImageFormat::kNifti:
      return itk::NiftiImageIO::New().GetPointer();
    case ImageFormat::kNrrd:
      return itk::NrrdImageIO::New().GetPointer();
    case ImageFormat::kMetaImage:
      return itk::MetaImageIO::New().GetPointer();
    case ImageFormat::kNone:
      break;
  }
  return nullptr;
}

Result<void> check_kind(const itk::ImageIOBase& io, const std::string& name) {
  const unsigned num_dimensions = io.GetNumberOfDimensions();
  for (unsigned axis = 3; axis < num_dimensions; ++axis) {
    if (io.GetDimensions(axis) != 1) {
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

enum class VoxelKind { kHu, kLabel };

struct VoxelTarget {
  std::string name;  ///< Of the file.
  VoxelKind kind;
};

/// Whatever type the file has: HU are rounded and cut to what a CT can hold, labels must be whole.
template <class Stored>
Result<void> convert(std::span<const std::byte> bytes,
                     std::span<std::int16_t> voxels,
                     const VoxelTarget& target) {
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    Stored value;
    std::memcpy(&value, bytes.data() + i * sizeof(Stored), sizeof(Stored));
    const auto number = static_cast<double>(value);
    if (!std::isfinite(number)) {
      return make_error(ErrorCode::kInvalidArgument,
                        target.name + " has a voxel that is not a number (voxel " +
                            std::to_string(i) + "): replace such voxels with -1024");
    }
    if (target.kind == VoxelKind::kLabel &&
        (number < 0.0 || number > 32767.0 || number != std::floor(number))) {
      return make_error(ErrorCode::kInvalidArgument,
                        target.name + " is no label map: its voxel " + std::to_string(i) + " is " +
                            std::to_string(number) + ", labels are whole numbers from 0 to 32767");
    }
    voxels[i] = static_cast<std::int16_t>(std::lround(std::clamp(number, -32768.0, 32767.0)));
  }
  return {};
}

Result<void> convert(itk::IOComponentEnum type,
                     std::span<const std::byte> bytes,
                     std::span<std::int16_t> voxels,
                     const VoxelTarget& target) {
  using Type = itk::IOComponentEnum;
  switch (type) {
    case Type::UCHAR:
      return convert<unsigned char>(bytes, voxels, target);
    case Type::CHAR:
      return convert<signed char>(bytes, voxels, target);
    case Type::USHORT:
      return convert<unsigned short>(bytes, voxels, target);
    case Type::SHORT:
      return convert<short>(bytes, voxels, target);
    case Type::UINT:
      return convert<unsigned>(bytes, voxels, target);
    case Type::INT:
      return convert<int>(bytes, voxels, target);
    case Type::ULONG:
      return convert<unsigned long>(bytes, voxels, target);
    case Type::LONG:
      return convert<long>(bytes, voxels, target);
    case Type::ULONGLONG:
      return convert<unsigned long long>(bytes, voxels, target);
    case Type::LONGLONG:
      return convert<long long>(bytes, voxels, target);
    case Type::FLOAT:
      return convert<float>(bytes, voxels, target);
    case Type::DOUBLE:
      return convert<double>(bytes, voxels, target);
    default:
      break;
  }
  return make_error(
      ErrorCode::kUnsupported,
      target.name + " stores its voxels in a type that is not read: convert it to 16-bit");
}

/// What the file announces must be possible with as many bytes as it has.
Result<void> check_announced(const std::filesystem::path& path, std::uintmax_t num_bytes) {
  const auto has = bytes_for_voxels(path);
  if (num_bytes <= max_inflated_bytes(has)) return {};
  return make_error(ErrorCode::kInvalidArgument,
                    path.filename().string() + " announces " + std::to_string(num_bytes) +
                        " bytes of voxels, more than its " + std::to_string(has) +
                        " bytes could hold");
}

std::vector<std::byte> stored_voxels(itk::ImageIOBase& io) {
  itk::ImageIORegion all(io.GetNumberOfDimensions());
  for (unsigned axis = 0; axis < io.GetNumberOfDimensions(); ++axis) {
    all.SetIndex(axis, 0);
    all.SetSize(axis, io.GetDimensions(axis));
  }
  io.SetIORegion(all);
  std::vector<std::byte> voxels(static_cast<std::size_t>(io.GetImageSizeInBytes()));
  io.Read(voxels.data());
  return voxels;
}

Result<void> import_voxels(const std::filesystem::path& path, VoxelKind kind) {
  const std::string name = path.filename().string();
  const ImageFormat format = image_format_of(path);
  auto io = make_image_io(format);
  if (!io) {
    return make_error(
        ErrorCode::kUnsupported,
        name +
            " is no CT that is read here: give a DICOM folder, DICOMDIR or .zip, or a "
            ".nii, .nii.gz, .nrrd, .nhdr, .mha or .mhd file");
  }
  say_file(path.string());
  MOR_CHECK(check_head(path, format));
  limit_time_for(bytes_for_voxels(path));
  if (!io->CanReadFile(path.c_str()))
    return make_error(ErrorCode::kIo, name + " is damaged or not what its name says");
  itk::Object::SetGlobalWarningDisplay(false);  // Nobody reads them.
  try {
    io->SetFileName(path.string());
    io->ReadImageInformation();
    MOR_CHECK(check_kind(*io, name));
    MOR_TRY(const ImportHeader header, header_of(*io, name));
    const auto num_bytes = static_cast<std::uintmax_t>(io->GetImageSizeInBytes());
    MOR_CHECK(check_announced(path, num_bytes));
    MOR_CHECK(check_length(
        path, format, static_cast<std::uintmax_t>(io->GetImageSizeInPixels()), num_bytes));
    // The reader keeps a copy of its own while it reads.
    const std::uintmax_t num_hu_bytes = sizeof(std::int16_t) * io->GetImageSizeInPixels();
    allow_memory(2 * std::max(num_bytes, num_hu_bytes));
    say_progress(0.2);
    const auto voxels = stored_voxels(*io);
    const auto type = io->GetComponentType();
    io = nullptr;
    say_progress(0.7);
    MOR_TRY(const auto hu, open_voxels(header));
    return convert(type, voxels, hu, {name, kind});
  } catch (const itk::ExceptionObject&) {
    // ITK's sentence is several lines about its own source: it does not help who has the file.
    return make_error(ErrorCode::kIo,
                      name +
                          " cannot be read: it is cut short, or its header has a "
                          "wrong size, spacing or type");
  }
}

}  // namespace

Result<void> import_image_file(const std::filesystem::path& path) {
  return import_voxels(path, VoxelKind::kHu);
}

Result<void> import_label_file(const std::filesystem::path& path) {
  MOR_CHECK(import_voxels(path, VoxelKind::kLabel));
  say_label_names(path);
  return {};
}

}  // namespace mor::import

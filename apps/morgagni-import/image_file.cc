// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "image_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <span>
#include <sstream>
#include <string>
#include <system_error>

#include <itkMetaImageIO.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <zlib.h>

#include "inflate.h"
#include "label_names.h"
#include "messages.h"
#include "sandbox.h"

namespace mor::import {
namespace {

bool ends_with(const std::string& text, std::string_view end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char letter) {
    return static_cast<char>(std::tolower(letter));
  });
  return text;
}

bool is_meta_image(const std::string& name) {
  return ends_with(lower_case(name), ".mha") || ends_with(lower_case(name), ".mhd");
}

/// ITK takes a MetaImage that is cut short without a word, so its length is checked here.
Result<void> check_meta_length(const std::filesystem::path& path, std::uintmax_t num_bytes) {
  std::ifstream file(path, std::ios::binary);
  std::string data_file;
  for (std::string line; data_file.empty() && std::getline(file, line);) {
    const auto equals = line.find('=');
    if (equals == std::string::npos) break;
    std::string key;
    std::string value;
    std::istringstream(line.substr(0, equals)) >> key;
    std::istringstream(line.substr(equals + 1)) >> value;
    if (key == "CompressedData" && lower_case(value) == "true") num_bytes = 0;
    if (key == "CompressedDataSize") num_bytes = std::strtoull(value.c_str(), nullptr, 10);
    if (key == "ElementDataFile") data_file = value;
  }
  if (data_file == "LIST" || data_file.find('%') != std::string::npos) return {};
  std::error_code failure;
  std::uintmax_t left = 0;
  if (data_file == "LOCAL") {
    left = std::filesystem::file_size(path, failure) - static_cast<std::uintmax_t>(file.tellg());
  } else {
    left = std::filesystem::file_size(path.parent_path() / data_file, failure);
  }
  if (!failure && left >= num_bytes) return {};
  return make_error(ErrorCode::kIo,
                    path.filename().string() + " is cut short: " + std::to_string(num_bytes) +
                        " bytes of voxels are announced, " + std::to_string(failure ? 0 : left) +
                        " are there");
}

/// Without the magic it would be an ANALYZE file, which says nothing about left and right.
bool is_nifti_head(std::span<const char> bytes) {
  constexpr std::size_t kMagic1At = 344;
  constexpr std::size_t kMagic2At = 4;
  if (bytes.size() < kMagic1At + 4) return false;
  const auto is_at = [&](std::size_t at, std::string_view magic) {
    return std::string_view(bytes.data() + at, magic.size()) == magic;
  };
  const auto begins = [&](unsigned char low, unsigned char high) {
    const auto at = [&](std::size_t i) { return static_cast<unsigned char>(bytes[i]); };
    return (at(0) == low && at(1) == high && at(2) == 0 && at(3) == 0) ||
           (at(3) == low && at(2) == high && at(1) == 0 && at(0) == 0);
  };
  if (begins(0x5c, 0x01)) return is_at(kMagic1At, "n+1") || is_at(kMagic1At, "ni1");
  return begins(0x1c, 0x02) && (is_at(kMagic2At, "n+2") || is_at(kMagic2At, "ni2"));
}

/// ITK fills up a NIfTI that is cut short without a word too: all of it is read through once.
/// @param num_voxels  That the header announces.
Result<void> check_nifti_length(const std::filesystem::path& path, std::uintmax_t num_voxels) {
  constexpr std::size_t kHeaderBytes = 348;
  constexpr std::size_t kBitsPerVoxelAt = 72;
  constexpr std::size_t kVoxelsStartAt = 108;
  // zlib reads files that are not compressed as they are.
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(::gzopen(path.c_str(), "rb"), ::gzclose);
  std::vector<char> bytes(std::size_t{1} << 20);
  std::uintmax_t num_bytes = 0;
  std::uintmax_t num_wanted = num_voxels;
  while (file) {
    const int got = ::gzread(file.get(), bytes.data(), static_cast<unsigned>(bytes.size()));
    if (got <= 0) break;
    if (num_bytes == 0 && !is_nifti_head({bytes.data(), static_cast<std::size_t>(got)}))
      return make_error(ErrorCode::kIo,
                        path.filename().string() +
                            " is no NIfTI file: its head is damaged, or of an older "
                            "format that does not tell left from right");
    std::int32_t header_bytes = 0;
    std::memcpy(&header_bytes, bytes.data(), sizeof(header_bytes));
    if (num_bytes == 0 && got >= static_cast<int>(kHeaderBytes) && header_bytes == kHeaderBytes) {
      std::int16_t bits = 0;
      float start = 0.0F;
      std::memcpy(&bits, bytes.data() + kBitsPerVoxelAt, sizeof(bits));
      std::memcpy(&start, bytes.data() + kVoxelsStartAt, sizeof(start));
      if (bits > 0 && start >= 0.0F && start < 1e9F)
        num_wanted =
            num_voxels * static_cast<std::uintmax_t>(bits) / 8 + static_cast<std::uintmax_t>(start);
    }
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

/// Teem ends the whole process over a NRRD of many dimensions: they are counted before it looks.
Result<void> check_nrrd_dimensions(const std::filesystem::path& path) {
  constexpr int kMaxLines = 200;
  constexpr std::string_view kKey = "dimension:";
  std::ifstream file(path, std::ios::binary);
  std::string line;
  for (int i = 0; i < kMaxLines && std::getline(file, line) && !line.empty(); ++i) {
    if (!line.starts_with(kKey)) continue;
    const long num_dimensions = std::strtol(line.c_str() + kKey.size(), nullptr, 10);
    if (num_dimensions >= 2 && num_dimensions <= 4) return {};
    return make_error(ErrorCode::kUnsupported,
                      path.filename().string() + " has " + std::to_string(num_dimensions) +
                          " dimensions, a CT has 3: give a volume");
  }
  return {};
}

/// The reader that the file's name asks for; none for other names.
itk::ImageIOBase::Pointer make_image_io(const std::filesystem::path& path) {
  const std::string name = lower_case(path.filename().string());
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
  const std::string name = lower_case(path.filename().string());
  std::error_code failure;
  const auto has = std::filesystem::file_size(path, failure);
  const bool is_detached = ends_with(name, ".nhdr") || ends_with(name, ".mhd");
  if (is_detached || (!failure && num_bytes <= max_inflated_bytes(has))) return {};
  return make_error(ErrorCode::kInvalidArgument,
                    path.filename().string() + " announces " + std::to_string(num_bytes) +
                        " bytes of voxels, more than its " + std::to_string(failure ? 0 : has) +
                        " bytes could hold");
}

Result<void> check_lengths(const std::filesystem::path& path, itk::ImageIOBase& io) {
  const auto num_bytes = static_cast<std::uintmax_t>(io.GetImageSizeInBytes());
  MOR_CHECK(check_announced(path, num_bytes));
  if (is_meta_image(path.filename().string())) return check_meta_length(path, num_bytes);
  if (dynamic_cast<const itk::NiftiImageIO*>(&io) != nullptr)
    return check_nifti_length(path, static_cast<std::uintmax_t>(io.GetImageSizeInPixels()));
  return {};
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
  auto io = make_image_io(path);
  if (!io) {
    return make_error(
        ErrorCode::kUnsupported,
        name +
            " is no CT that is read here: give a DICOM folder, DICOMDIR or .zip, or a "
            ".nii, .nii.gz, .nrrd, .nhdr, .mha or .mhd file");
  }
  say_file(path.string());
  if (dynamic_cast<const itk::NrrdImageIO*>(io.GetPointer()) != nullptr)
    MOR_CHECK(check_nrrd_dimensions(path));
  if (!io->CanReadFile(path.c_str()))
    return make_error(ErrorCode::kIo, name + " is damaged or not what its name says");
  try {
    io->SetFileName(path.string());
    io->ReadImageInformation();
    MOR_CHECK(check_kind(*io, name));
    MOR_TRY(const ImportHeader header, header_of(*io, name));
    MOR_CHECK(check_lengths(path, *io));
    // The reader keeps a copy of its own while it reads.
    allow_memory(2 * static_cast<std::uint64_t>(io->GetImageSizeInBytes()));
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

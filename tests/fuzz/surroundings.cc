// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "surroundings.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <numeric>
#include <string>
#include <vector>

#include <fcntl.h>
#include <unistd.h>

#include "morgagni/ct/import_protocol.h"
#include "morgagni/ct/internal/volume_header.h"

#include "messages.h"
#include "sandbox.h"

namespace mor {
namespace {

constexpr std::size_t kMaxBytes = std::size_t{4} << 20U;  ///< More teaches a fuzzer nothing.

/// The readers' messages go nowhere, and not into what libFuzzer would open under their number.
const bool kMessagesGoNowhere =
    ::dup2(::open("/dev/null", O_WRONLY | O_CLOEXEC), kImportMessagesFd) == kImportMessagesFd;

HuArray voxels;
std::vector<float> positions;
std::vector<std::uint32_t> indices;
ImportHeader header;

[[noreturn]] void fail(const char* why) {
  std::fprintf(stderr, "%s\n", why);
  std::abort();
}

}  // namespace

namespace import {

Result<void> give_up_rights(const std::filesystem::path&) {
  return {};
}
void allow_memory(std::uint64_t) {}
void spend_on_hand_over(std::uint64_t) {}
void limit_time_for(std::uint64_t) {}

Result<std::span<std::int16_t>> open_voxels(const ImportHeader& what) {
  std::size_t num_voxels = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (what.size[axis] < 0) fail("a side below 0 is handed over");
    num_voxels *= static_cast<std::size_t>(what.size[axis]);
  }
  if (num_voxels * sizeof(std::int16_t) > static_cast<std::size_t>(kMaxVolumeBytes))
    fail("more voxels than the limit are handed over");
  if (num_voxels * sizeof(std::int16_t) > kMaxBytes)
    return make_error(ErrorCode::kInvalidArgument, "more than fuzzing takes");
  header = what;
  voxels.assign(num_voxels, 0);
  return std::span<std::int16_t>(voxels);
}

Result<MeshPlace> open_mesh(const ImportMeshHeader& what) {
  const std::size_t num_bytes =
      12 * static_cast<std::size_t>(what.num_vertices + what.num_triangles);
  if (what.num_triangles > kMaxMeshTriangles) fail("more triangles than the limit");
  if (num_bytes > kMaxBytes)
    return make_error(ErrorCode::kInvalidArgument, "more than fuzzing takes");
  positions.assign(3 * what.num_vertices, 0.0F);
  indices.assign(3 * what.num_triangles, 0);
  return MeshPlace{positions, indices};
}

}  // namespace import

namespace fuzz {

const std::filesystem::path& scratch_folder() {
  static const struct Folder {
    std::filesystem::path path = "/dev/shm/morgagni_fuzz_" + std::to_string(::getpid());
    Folder() { std::filesystem::create_directories(path); }
    ~Folder() { std::filesystem::remove_all(path); }
  } kFolder;
  return kFolder.path;
}

std::filesystem::path write(std::string_view name, std::span<const std::byte> bytes) {
  auto path = scratch_folder() / name;
  std::ofstream(path, std::ios::binary | std::ios::trunc)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  return path;
}

void take_over() {
  if (!voxels.empty()) {
    auto volume = internal::volume_from_header(header);
    if (volume) {
      volume->hu = voxels;
      internal::make_right_handed(*volume);
    }
  }
  for (const auto index : indices)
    if (3 * static_cast<std::size_t>(index) >= positions.size())
      fail("a triangle names a vertex that is not there");
  voxels.clear();
  positions.clear();
  indices.clear();
}

}  // namespace fuzz
}  // namespace mor

/// Libraries that are not instrumented fill containers behind the sanitizer's back.
extern "C" const char* __asan_default_options() {
  return "detect_container_overflow=0:allocator_may_return_null=1:detect_leaks=0";
}

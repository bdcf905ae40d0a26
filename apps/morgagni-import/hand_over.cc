// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
// What was read goes into the parent's memory file.
#include <cstring>

#include <sys/mman.h>
#include <unistd.h>

#include "messages.h"
#include "sandbox.h"

namespace mor::import {
namespace {

/// The parent's memory file, as large as asked for and mapped until the process ends, which is when
/// the parent takes it over. Begins with the header.
template <class Header>
Result<char*> open_memory(const Header& header, std::size_t num_bytes) {
  const auto no_memory =
      make_error(ErrorCode::kIo, "there is not enough memory to hand over what was read");
  spend_on_hand_over(num_bytes);
  if (::ftruncate(kImportVoxelsFd, static_cast<off_t>(num_bytes)) != 0) return no_memory;
  void* memory = ::mmap(nullptr, num_bytes, PROT_READ | PROT_WRITE, MAP_SHARED, kImportVoxelsFd, 0);
  if (memory == MAP_FAILED) return no_memory;
  std::memcpy(memory, &header, sizeof(header));
  return static_cast<char*>(memory);
}

}  // namespace

Result<std::span<std::int16_t>> open_voxels(const ImportHeader& header) {
  std::size_t num_voxels = 1;
  for (std::size_t axis = 0; axis < 3; ++axis)
    num_voxels *= static_cast<std::size_t>(header.size[axis]);
  MOR_TRY(char* memory, open_memory(header, sizeof(header) + num_voxels * sizeof(std::int16_t)));
  return std::span<std::int16_t>(reinterpret_cast<std::int16_t*>(memory + sizeof(header)),
                                 num_voxels);
}

Result<MeshPlace> open_mesh(const ImportMeshHeader& header) {
  const std::size_t num_floats = 3 * header.num_vertices;
  const std::size_t num_indices = 3 * header.num_triangles;
  MOR_TRY(char* memory,
          open_memory(
              header,
              sizeof(header) + num_floats * sizeof(float) + num_indices * sizeof(std::uint32_t)));
  auto* positions = reinterpret_cast<float*>(memory + sizeof(header));
  return MeshPlace{{positions, num_floats},
                   {reinterpret_cast<std::uint32_t*>(positions + num_floats), num_indices}};
}

}  // namespace mor::import

// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "morgagni/compute/compute_context.h"
#include "morgagni/registration/internal/icp_backend.h"

namespace mor::internal {

/// The kernels of kernels/icp_*.cl on one device, and the two that take several launches: sorting
/// and summing.
struct IcpKernels {
  static constexpr std::size_t kGroupSize = 64;
  /// Groups of a sum: enough to fill a large GPU, few enough to be added up by one group.
  static constexpr std::size_t kNumSumGroups = 64;

  /// @errors kDevice: the device does not compile or hold them.
  [[nodiscard]] static Result<IcpKernels> build(ComputeContext& context, SumPrecision precision);

  /// Leaves in `sort_order` the indices of the `num_points` first distances, smallest first, equal
  /// ones in their own order.
  [[nodiscard]] Result<void> sort(ComputeContext& context,
                                  const ComputeBuffer& distances_sq,
                                  std::size_t num_points);

  /// Runs a summing kernel, whose last argument are the groups' sums, and adds those up.
  template <class... Arguments>
  [[nodiscard]] Result<void> reduce(ComputeContext& context,
                                    std::span<double> totals,
                                    ComputeKernel& kernel,
                                    const Arguments&... arguments) {
    MOR_CHECK(
        context.run(kernel, {kNumSumGroups * kGroupSize, kGroupSize}, arguments..., group_sums));
    return add_groups(context, totals);
  }

  ComputeKernel move_points;
  ComputeKernel turn_errors;
  ComputeKernel find_nearest;
  ComputeKernel find_nearest_weighted;
  ComputeKernel fill_sort;
  ComputeKernel sort_blocks;
  ComputeKernel merge_runs;
  ComputeKernel sum_pairs;
  ComputeKernel sum_equations;
  ComputeKernel sum_groups;
  SumPrecision precision = SumPrecision::kSingle;
  /// Of sort_blocks. The larger, the fewer launches: they are what a GPU's sorting takes.
  std::size_t sort_group_size = kGroupSize;
  ComputeBuffer group_sums = {};
  ComputeBuffer total_sums = {};
  ComputeBuffer sort_keys = {};
  ComputeBuffer sort_order = {};

 private:
  [[nodiscard]] std::size_t num_sort_entries(std::size_t num_points) const;
  /// Makes room to sort so many entries, once and for all sorts that are no larger.
  [[nodiscard]] Result<void> reserve_sort(ComputeContext& context, std::size_t num_points);
  [[nodiscard]] Result<void> add_groups(ComputeContext& context, std::span<double> totals);
};

}  // namespace mor::internal

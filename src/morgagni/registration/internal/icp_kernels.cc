// SPDX-FileCopyrightText: 2026 The Morgagni authors
// SPDX-License-Identifier: BSD-3-Clause
#include "morgagni/registration/internal/icp_kernels.h"

#include <algorithm>
#include <bit>

#include <spdlog/fmt/fmt.h>

namespace mor::internal {
namespace {

constexpr const char* kSource =
#include "embedded/icp_common.cl.inc"
#include "embedded/icp_pairs.cl.inc"
#include "embedded/icp_sort.cl.inc"
#include "embedded/icp_sums.cl.inc"
    ;

/// The longest row of sums: WeightedEquations.
constexpr std::size_t kMaxSums = 28;

/// 16 KiB of local memory: half of what every OpenCL device has.
constexpr std::size_t kMostSortGroup = 1024;

}  // namespace

Result<IcpKernels> IcpKernels::build(ComputeContext& context, SumPrecision precision) {
  if (!context.device().has_double) precision = SumPrecision::kSingle;
  const bool in_double = precision == SumPrecision::kDouble;
  const std::size_t sort_group_size =
      std::clamp(std::bit_floor(context.device().max_group_size), kGroupSize, kMostSortGroup);
  MOR_TRY(const auto program,
          context.build(kSource,
                        fmt::format("-DGROUP_SIZE={} -DSORT_GROUP_SIZE={}{}",
                                    kGroupSize,
                                    sort_group_size,
                                    in_double ? " -DSUM_DOUBLE" : "")));
  MOR_TRY(auto move_points, program.kernel("move_points"));
  MOR_TRY(auto turn_errors, program.kernel("turn_errors"));
  MOR_TRY(auto find_nearest, program.kernel("find_nearest"));
  MOR_TRY(auto find_nearest_weighted, program.kernel("find_nearest_weighted"));
  MOR_TRY(auto fill_sort, program.kernel("fill_sort"));
  MOR_TRY(auto sort_blocks, program.kernel("sort_blocks"));
  MOR_TRY(auto merge_runs, program.kernel("merge_runs"));
  MOR_TRY(auto sum_pairs, program.kernel("sum_pairs"));
  MOR_TRY(auto sum_equations, program.kernel("sum_equations"));
  MOR_TRY(auto sum_groups, program.kernel("sum_groups"));
  const std::size_t sum_bytes = in_double ? sizeof(double) : sizeof(float);
  MOR_TRY(auto group_sums, context.allocate(kNumSumGroups * kMaxSums * sum_bytes));
  MOR_TRY(auto total_sums, context.allocate(kMaxSums * sum_bytes));
  return IcpKernels{.move_points = std::move(move_points),
                    .turn_errors = std::move(turn_errors),
                    .find_nearest = std::move(find_nearest),
                    .find_nearest_weighted = std::move(find_nearest_weighted),
                    .fill_sort = std::move(fill_sort),
                    .sort_blocks = std::move(sort_blocks),
                    .merge_runs = std::move(merge_runs),
                    .sum_pairs = std::move(sum_pairs),
                    .sum_equations = std::move(sum_equations),
                    .sum_groups = std::move(sum_groups),
                    .precision = precision,
                    .sort_group_size = sort_group_size,
                    .group_sums = std::move(group_sums),
                    .total_sums = std::move(total_sums)};
}

std::size_t IcpKernels::num_sort_entries(std::size_t num_points) const {
  return std::max(2 * sort_group_size, std::bit_ceil(num_points));
}

Result<void> IcpKernels::reserve_sort(ComputeContext& context, std::size_t num_points) {
  const std::size_t num_entries = num_sort_entries(num_points);
  // By both: a failed allocation of the second leaves it smaller than the first.
  if (num_entries * sizeof(float) <= sort_keys.num_bytes() &&
      num_entries * sizeof(std::uint32_t) <= sort_order.num_bytes()) {
    return {};
  }
  MOR_TRY(sort_keys, context.allocate(num_entries * sizeof(float)));
  MOR_TRY(sort_order, context.allocate(num_entries * sizeof(std::uint32_t)));
  return {};
}

Result<void> IcpKernels::sort(ComputeContext& context,
                              const ComputeBuffer& distances_sq,
                              std::size_t num_points) {
  MOR_CHECK(reserve_sort(context, num_points));
  const auto num_entries = static_cast<std::uint32_t>(num_sort_entries(num_points));
  const auto block = static_cast<std::uint32_t>(2 * sort_group_size);
  const WorkSize one_each = WorkSize::at_least(num_entries, kGroupSize);
  const WorkSize one_a_pair = WorkSize::at_least(num_entries / 2, sort_group_size);
  MOR_CHECK(context.run(fill_sort,
                        one_each,
                        static_cast<std::uint32_t>(num_points),
                        num_entries,
                        distances_sq,
                        sort_keys,
                        sort_order));
  MOR_CHECK(context.run(sort_blocks, one_a_pair, std::uint32_t{2}, block, sort_keys, sort_order));
  for (std::uint32_t run = 2 * block; run <= num_entries; run *= 2) {
    for (std::uint32_t stride = run / 2; stride >= block; stride /= 2) {
      MOR_CHECK(
          context.run(merge_runs, one_a_pair, num_entries, run, stride, sort_keys, sort_order));
    }
    MOR_CHECK(context.run(sort_blocks, one_a_pair, run, run, sort_keys, sort_order));
  }
  return {};
}

Result<void> IcpKernels::add_groups(ComputeContext& context, std::span<double> totals) {
  MOR_CHECK(context.run(sum_groups,
                        {kGroupSize, kGroupSize},
                        static_cast<std::uint32_t>(kNumSumGroups),
                        static_cast<std::uint32_t>(totals.size()),
                        group_sums,
                        total_sums));
  if (precision == SumPrecision::kDouble) return context.read<double>(total_sums, totals);
  std::vector<float> single(totals.size());
  MOR_CHECK(context.read<float>(total_sums, single));
  std::copy(single.begin(), single.end(), totals.begin());
  return {};
}

}  // namespace mor::internal

// Parallel reductions over the pairs: each work item adds up its share, a group adds its items' in
// local memory, and sum_groups adds the groups'. The order of additions is fixed.

#define NUM_PAIR_SUMS 19
#define NUM_EQUATION_SUMS 28

// Adds the items' sums into the first item's. sums: NUM values an item.
void reduce_group(__local sum_t* sums, const uint num_sums) {
  const uint item = get_local_id(0);
  for (uint half_size = GROUP_SIZE / 2; half_size > 0; half_size /= 2) {
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item < half_size) {
      for (uint k = 0; k < num_sums; ++k) {
        sums[item * num_sums + k] += sums[(item + half_size) * num_sums + k];
      }
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE);
}

void write_group_sums(__local const sum_t* sums,
                             const uint num_sums,
                             __global sum_t* group_sums) {
  for (uint k = get_local_id(0); k < num_sums; k += GROUP_SIZE) {
    group_sums[get_group_id(0) * num_sums + k] = sums[k];
  }
}

// One group: the sums of all groups.
__kernel void sum_groups(const uint num_groups,
                         const uint num_sums,
                         __global const sum_t* group_sums,
                         __global sum_t* totals) {
  for (uint k = get_local_id(0); k < num_sums; k += GROUP_SIZE) {
    sum_t total = 0;
    for (uint group = 0; group < num_groups; ++group) total += group_sums[group * num_sums + k];
    totals[k] = total;
  }
}

// order: the points by distance where pairs were left out, of which the first num_kept count; not
// read where all count. The sums are PairSums' in the order of its members.
__kernel void sum_pairs(const uint num_points,
                        const uint num_kept,
                        const float explained_mm2,
                        const float near_mm2,
                        const float4 moving_pivot,
                        const float4 fixed_pivot,
                        __global const uint* order,
                        __global const float4* moving,
                        __global const float4* moved,
                        __global const float4* tree,
                        __global const uint* partners,
                        __global const float* distances_sq,
                        __global sum_t* group_sums) {
  __local sum_t all[GROUP_SIZE * NUM_PAIR_SUMS];
  __local sum_t* sums = all + get_local_id(0) * NUM_PAIR_SUMS;
  for (uint k = 0; k < NUM_PAIR_SUMS; ++k) sums[k] = 0;
  for (uint rank = get_global_id(0); rank < num_points; rank += get_global_size(0)) {
    const uint i = num_kept < num_points ? order[rank] : rank;
    const float3 partner = tree[partners[i]].xyz;
    const float apart_mm2 = distance_sq(moved[i].xyz, partner);
    sums[0] += apart_mm2 <= explained_mm2 ? 1 : 0;
    sums[1] += apart_mm2 <= near_mm2 ? 1 : 0;
    if (rank >= num_kept) continue;
    const float3 p = moving[i].xyz - moving_pivot.xyz;
    const float3 q = partner - fixed_pivot.xyz;
    sums[2] += apart_mm2;
    sums[3] += distances_sq[i];
    sums[4] += p.x;
    sums[5] += p.y;
    sums[6] += p.z;
    sums[7] += q.x;
    sums[8] += q.y;
    sums[9] += q.z;
    sums[10] += (sum_t)p.x * q.x;
    sums[11] += (sum_t)p.x * q.y;
    sums[12] += (sum_t)p.x * q.z;
    sums[13] += (sum_t)p.y * q.x;
    sums[14] += (sum_t)p.y * q.y;
    sums[15] += (sum_t)p.y * q.z;
    sums[16] += (sum_t)p.z * q.x;
    sums[17] += (sum_t)p.z * q.y;
    sums[18] += (sum_t)p.z * q.z;
  }
  reduce_group(all, NUM_PAIR_SUMS);
  write_group_sums(all, NUM_PAIR_SUMS, group_sums);
}

void add_three(__local sum_t* sums, const float3 v) {
  sums[0] += v.x;
  sums[1] += v.y;
  sums[2] += v.z;
}

// WeightedEquations of the pairs that count: the information's rows (turn x: 6 values from the
// diagonal on, turn y: 5, ... shift z: 1), the gradient, the weighted squared distances.
__kernel void sum_equations(const uint num_points,
                            const uint num_kept,
                            const float4 pivot,
                            __global const uint* order,
                            __global const float4* moved,
                            __global const float4* moved_errors,
                            __global const float4* tree,
                            __global const float4* fixed_errors,
                            __global const uint* partners,
                            __global sum_t* group_sums) {
  __local sum_t all[GROUP_SIZE * NUM_EQUATION_SUMS];
  __local sum_t* sums = all + get_local_id(0) * NUM_EQUATION_SUMS;
  for (uint k = 0; k < NUM_EQUATION_SUMS; ++k) sums[k] = 0;
  for (uint rank = get_global_id(0); rank < num_kept; rank += get_global_size(0)) {
    const uint i = num_kept < num_points ? order[rank] : rank;
    const uint partner = partners[i];
    const float3 p = moved[i].xyz;
    const Symmetric weight = inverse(pair_covariance(moved_errors[i], fixed_errors[partner]));
    const float3 residual = p - tree[partner].xyz;
    const float3 weighted = times(weight, residual);
    const float3 lever = p - pivot.xyz;
    // How a turn about each axis moves the point, and the same weighted.
    const float3 turn_x = (float3)(0.0f, -lever.z, lever.y);
    const float3 turn_y = (float3)(lever.z, 0.0f, -lever.x);
    const float3 turn_z = (float3)(-lever.y, lever.x, 0.0f);
    const float3 weighted_x = times(weight, turn_x);
    const float3 weighted_y = times(weight, turn_y);
    const float3 weighted_z = times(weight, turn_z);
    sums[0] += dot(turn_x, weighted_x);
    sums[1] += dot(turn_x, weighted_y);
    sums[2] += dot(turn_x, weighted_z);
    add_three(sums + 3, weighted_x);
    sums[6] += dot(turn_y, weighted_y);
    sums[7] += dot(turn_y, weighted_z);
    add_three(sums + 8, weighted_y);
    sums[11] += dot(turn_z, weighted_z);
    add_three(sums + 12, weighted_z);
    add_three(sums + 15, (float3)(weight.xx, weight.xy, weight.xz));
    sums[18] += weight.yy;
    sums[19] += weight.yz;
    sums[20] += weight.zz;
    sums[21] += dot(turn_x, weighted);
    sums[22] += dot(turn_y, weighted);
    sums[23] += dot(turn_z, weighted);
    add_three(sums + 24, weighted);
    sums[27] += dot(residual, weighted);
  }
  reduce_group(all, NUM_EQUATION_SUMS);
  write_group_sums(all, NUM_EQUATION_SUMS, group_sums);
}

// Bitonic sort (Batcher 1968) of pairs by distance, equals by index, so that any order of the work
// gives the same result. The number of entries is a power of two, at least SORT_BLOCK; the host
// pads with distances that sort last.

#define SORT_BLOCK (2 * SORT_GROUP_SIZE)

// Fills the entries: the pairs' distances, then padding.
__kernel void fill_sort(const uint num_points,
                        const uint num_entries,
                        __global const float* distances_sq,
                        __global float* keys,
                        __global uint* order) {
  const uint i = get_global_id(0);
  if (i >= num_entries) return;
  keys[i] = i < num_points ? distances_sq[i] : INFINITY;
  order[i] = i;
}

bool comes_after(const float key_a, const uint idx_a, const float key_b, const uint idx_b) {
  return key_a > key_b || (key_a == key_b && idx_a > idx_b);
}

// The lower of the two entries that work item `item` compares at a distance of `stride`.
uint lower_entry(const uint item, const uint stride) {
  return 2 * item - (item & (stride - 1));
}

void order_local(__local float* keys,
                        __local uint* order,
                        const uint a,
                        const uint b,
                        const bool ascending) {
  if (comes_after(keys[a], order[a], keys[b], order[b]) == ascending) {
    const float key = keys[a];
    keys[a] = keys[b];
    keys[b] = key;
    const uint idx = order[a];
    order[a] = order[b];
    order[b] = idx;
  }
}

// Within blocks, in local memory: makes the runs of low_run to high_run entries. Those longer than a
// block have been merged at strides of a block and more before.
__kernel void sort_blocks(const uint low_run,
                          const uint high_run,
                          __global float* all_keys,
                          __global uint* all_order) {
  __local float keys[SORT_BLOCK];
  __local uint order[SORT_BLOCK];
  const uint item = get_local_id(0);
  const uint begin = get_group_id(0) * SORT_BLOCK;
  for (uint i = item; i < SORT_BLOCK; i += SORT_GROUP_SIZE) {
    keys[i] = all_keys[begin + i];
    order[i] = all_order[begin + i];
  }
  for (uint size = low_run; size <= high_run; size *= 2) {
    for (uint stride = min(size / 2, (uint)SORT_GROUP_SIZE); stride > 0; stride /= 2) {
      barrier(CLK_LOCAL_MEM_FENCE);
      const uint a = lower_entry(item, stride);
      order_local(keys, order, a, a + stride, ((begin + a) & size) == 0);
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint i = item; i < SORT_BLOCK; i += SORT_GROUP_SIZE) {
    all_keys[begin + i] = keys[i];
    all_order[begin + i] = order[i];
  }
}

// One step at a stride of a block or more: one work item for two entries.
__kernel void merge_runs(const uint num_entries,
                         const uint run,
                         const uint stride,
                         __global float* keys,
                         __global uint* order) {
  const uint a = lower_entry(get_global_id(0), stride);
  const uint b = a + stride;
  if (b >= num_entries) return;
  const float key_a = keys[a];
  const float key_b = keys[b];
  const uint idx_a = order[a];
  const uint idx_b = order[b];
  if (comes_after(key_a, idx_a, key_b, idx_b) == ((a & run) == 0)) {
    keys[a] = key_b;
    keys[b] = key_a;
    order[a] = idx_b;
    order[b] = idx_a;
  }
}

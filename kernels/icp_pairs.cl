// Moving the camera's points and finding the nearest fixed point of each: one work item a point.

__kernel void move_points(const uint num_points,
                          const Pose pose,
                          __global const float4* moving,
                          __global float4* moved) {
  const uint i = get_global_id(0);
  if (i < num_points) moved[i] = (float4)(moved_by(pose, moving[i].xyz), 0.0f);
}

// Turns the points' errors along; w, the part without a direction, stays.
__kernel void turn_errors(const uint num_points,
                          const Pose pose,
                          __global const float4* errors,
                          __global float4* turned) {
  const uint i = get_global_id(0);
  if (i < num_points) turned[i] = (float4)(rotated(pose, errors[i].xyz), errors[i].w);
}

// The walk over the tree needs no stack: where it goes next follows from where it came from (Wald,
// "A stack-free traversal algorithm for left-balanced k-d trees", 2022). tree: a node's point, and
// its axis in w. VISIT(node) may lower the bound that IN_REACH(node, axis, distance_mm) looks at.
#define TRAVERSE(tree, num_nodes, query, VISIT, IN_REACH)                                    \
  {                                                                                          \
    int node = 0;                                                                            \
    int last = -1;                                                                           \
    while (node >= 0) {                                                                      \
      const int parent = (node + 1) / 2 - 1;                                                 \
      if (node >= (int)(num_nodes)) {                                                        \
        last = node;                                                                         \
        node = parent;                                                                       \
        continue;                                                                            \
      }                                                                                      \
      const float4 point = (tree)[node];                                                     \
      const bool from_above = last < node;                                                   \
      if (from_above) {                                                                      \
        VISIT(node, point.xyz)                                                               \
      }                                                                                      \
      const int axis = (int)point.w;                                                         \
      const float distance_mm = axis == 0   ? (query).x - point.x                            \
                                : axis == 1 ? (query).y - point.y                            \
                                            : (query).z - point.z;                           \
      const int near_child = 2 * node + (distance_mm > 0.0f ? 2 : 1);                        \
      const int far_child = 2 * node + (distance_mm > 0.0f ? 1 : 2);                         \
      int next = parent;                                                                     \
      if (from_above) {                                                                      \
        next = near_child;                                                                   \
      } else if (last == near_child && IN_REACH(node, axis, distance_mm)) {                   \
        next = far_child;                                                                    \
      }                                                                                      \
      last = node;                                                                           \
      node = next;                                                                           \
    }                                                                                        \
  }

// partners: of the pairing before, a first guess that bounds the search, or NO_PARTNER.
__kernel void find_nearest(const uint num_points,
                           const uint num_nodes,
                           __global const float4* moved,
                           __global const float4* tree,
                           __global uint* partners,
                           __global float* distances_sq) {
  const uint i = get_global_id(0);
  if (i >= num_points) return;
  const float3 query = moved[i].xyz;
  uint partner = partners[i];
  float best = partner == NO_PARTNER ? INFINITY : distance_sq(query, tree[partner].xyz);
#define VISIT_NEAREST(node, position)                   \
  const float here = distance_sq(query, position);      \
  if (here < best) {                                    \
    best = here;                                        \
    partner = (uint)node;                               \
  }
#define NEAREST_IN_REACH(node, axis, distance_mm) ((distance_mm) * (distance_mm) < best)
  TRAVERSE(tree, num_nodes, query, VISIT_NEAREST, NEAREST_IN_REACH)
  partners[i] = partner;
  distances_sq[i] = best;
}

// Nearest by d^T C^-1 d. No pair beyond a plane d away along an axis is nearer than d^2 over the
// variance along it: the point's own and largest_below_mm2, of the fixed points below that node.
__kernel void find_nearest_weighted(const uint num_points,
                                    const uint num_nodes,
                                    __global const float4* moved,
                                    __global const float4* moved_errors,
                                    __global const float4* tree,
                                    __global const float4* fixed_errors,
                                    __global const float* largest_below_mm2,
                                    __global uint* partners,
                                    __global float* distances_sq) {
  const uint i = get_global_id(0);
  if (i >= num_points) return;
  const float3 query = moved[i].xyz;
  const float4 error = moved_errors[i];
  const float3 own_mm2 = error.xyz * error.xyz + error.w;
  uint partner = partners[i];
  float best = INFINITY;
  if (partner != NO_PARTNER) {
    best = weighted_distance_sq(pair_covariance(error, fixed_errors[partner]),
                                query - tree[partner].xyz);
  }
#define VISIT_WEIGHTED(node, position)                                                          \
  const float here =                                                                            \
      weighted_distance_sq(pair_covariance(error, fixed_errors[node]), query - (position));     \
  if (here < best) {                                                                            \
    best = here;                                                                                \
    partner = (uint)node;                                                                       \
  }
#define WEIGHTED_IN_REACH(node, axis, distance_mm)                                        \
  ((distance_mm) * (distance_mm) <                                                        \
   best * (((axis) == 0 ? own_mm2.x : (axis) == 1 ? own_mm2.y : own_mm2.z) +              \
           largest_below_mm2[node]))
  TRAVERSE(tree, num_nodes, query, VISIT_WEIGHTED, WEIGHTED_IN_REACH)
  partners[i] = partner;
  distances_sq[i] = best;
}

// What the ICP kernels share. The host prepends this to them and defines
//   GROUP_SIZE  work items of a group, a power of two
//   SORT_GROUP_SIZE  the same where pairs are sorted, GROUP_SIZE or more
//   SUM_DOUBLE  where the device computes in double: sums are taken in it

#ifdef SUM_DOUBLE
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
typedef double sum_t;
#else
typedef float sum_t;
#endif

// As the CPU computes (icp_backend_cpu.cc), operation by operation: all devices pair the same points
// even where two are almost equally near.
#pragma OPENCL FP_CONTRACT OFF

#define NO_PARTNER 0xFFFFFFFFu

// Rows of a rotation, the shift in w. mm.
typedef struct {
  float4 row_x;
  float4 row_y;
  float4 row_z;
} Pose;

float sum_of_products(const float3 a, const float3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

float3 rotated(const Pose pose, const float3 v) {
  return (float3)(sum_of_products(pose.row_x.xyz, v),
                  sum_of_products(pose.row_y.xyz, v),
                  sum_of_products(pose.row_z.xyz, v));
}

float3 moved_by(const Pose pose, const float3 p) {
  return rotated(pose, p) + (float3)(pose.row_x.w, pose.row_y.w, pose.row_z.w);
}

float distance_sq(const float3 a, const float3 b) {
  return sum_of_products(a - b, a - b);
}

// A symmetric 3x3 matrix.
typedef struct {
  float xx, xy, xz, yy, yz, zz;
} Symmetric;

// Covariance of a pair's difference: (s_m + s_f) I + a a^T - b b^T, with a the moving point's error
// along its ray and b the fixed one's lack of it along its normal; each s is in w.
Symmetric pair_covariance(const float4 moved_error, const float4 fixed_error) {
  const float3 a = moved_error.xyz;
  const float3 b = fixed_error.xyz;
  const float sideways = moved_error.w + fixed_error.w;
  Symmetric c;
  c.xx = a.x * a.x - b.x * b.x + sideways;
  c.xy = a.x * a.y - b.x * b.y;
  c.xz = a.x * a.z - b.x * b.z;
  c.yy = a.y * a.y - b.y * b.y + sideways;
  c.yz = a.y * a.z - b.y * b.z;
  c.zz = a.z * a.z - b.z * b.z + sideways;
  return c;
}

Symmetric adjugate(const Symmetric c) {
  Symmetric a;
  a.xx = c.yy * c.zz - c.yz * c.yz;
  a.xy = c.xz * c.yz - c.xy * c.zz;
  a.xz = c.xy * c.yz - c.xz * c.yy;
  a.yy = c.xx * c.zz - c.xz * c.xz;
  a.yz = c.xy * c.xz - c.xx * c.yz;
  a.zz = c.xx * c.yy - c.xy * c.xy;
  return a;
}

float determinant(const Symmetric c, const Symmetric adjugate_of_c) {
  return c.xx * adjugate_of_c.xx + c.xy * adjugate_of_c.xy + c.xz * adjugate_of_c.xz;
}

float3 times(const Symmetric m, const float3 v) {
  return (float3)(sum_of_products((float3)(m.xx, m.xy, m.xz), v),
                  sum_of_products((float3)(m.xy, m.yy, m.yz), v),
                  sum_of_products((float3)(m.xz, m.yz, m.zz), v));
}

// d^T C^-1 d.
float weighted_distance_sq(const Symmetric c, const float3 d) {
  const Symmetric a = adjugate(c);
  return sum_of_products(d, times(a, d)) / determinant(c, a);
}

Symmetric inverse(const Symmetric c) {
  Symmetric i = adjugate(c);
  const float per_determinant = 1.0f / determinant(c, i);
  i.xx *= per_determinant;
  i.xy *= per_determinant;
  i.xz *= per_determinant;
  i.yy *= per_determinant;
  i.yz *= per_determinant;
  i.zz *= per_determinant;
  return i;
}

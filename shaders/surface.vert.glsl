#version 330 core
// A vertex of the CT on the camera's picture, as PinholeCamera::project puts it, distortion included.
layout(location = 0) in vec3 position_ct;
layout(location = 1) in vec3 normal_ct;
layout(location = 2) in vec2 place_in_atlas;  // Of the skin alone.

uniform mat4 camera_from_ct;
uniform vec2 focal_ndc;       // From (x/z, y/z) to the target's -1..1.
uniform vec2 center_ndc;
uniform float distortion[5];  // k1, k2, p1, p2, k3.
uniform float max_radius_sq;  // Of (x/z, y/z) that the distortion's polynomial bears; 0: no distortion.
uniform vec4 cut_plane;        // What is on its negative side is cut away, where clip distance 0 is on.
uniform vec2 depth_clip;      // clip z = depth_clip.x * z + depth_clip.y.

out vec3 position_mm;  // Camera frame: x right, y down, z forward.
out vec3 normal;
out vec2 atlas_place;

vec2 distorted(vec2 ray) {
  float r2 = dot(ray, ray);
  float radial = 1.0 + r2 * (distortion[0] + r2 * (distortion[1] + r2 * distortion[4]));
  return ray * radial + vec2(2.0 * distortion[2] * ray.x * ray.y + distortion[3] * (r2 + 2.0 * ray.x * ray.x),
                             distortion[2] * (r2 + 2.0 * ray.y * ray.y) + 2.0 * distortion[3] * ray.x * ray.y);
}

void main() {
  position_mm = (camera_from_ct * vec4(position_ct, 1.0)).xyz;
  normal = mat3(camera_from_ct) * normal_ct;
  atlas_place = place_in_atlas;
  vec2 seen = position_mm.xy;  // Times z: dividing is left to OpenGL, which clips before it.
  if (max_radius_sq > 0.0) {
    float z = abs(position_mm.z) < 1e-3 ? 1e-3 : position_mm.z;
    vec2 ray = position_mm.xy / z;
    // Far outside of the picture the polynomial folds back into it: go straight on from its edge.
    float shrink = min(1.0, sqrt(max_radius_sq / max(dot(ray, ray), 1e-12)));
    seen = distorted(ray * shrink) / shrink * z;
  }
  gl_ClipDistance[0] = dot(cut_plane, vec4(position_mm, 1.0));
  gl_Position = vec4(focal_ndc * seen + center_ndc * position_mm.z,
                     depth_clip.x * position_mm.z + depth_clip.y, position_mm.z);
}

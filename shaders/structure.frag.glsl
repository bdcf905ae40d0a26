#version 330 core
// Something inside of the body: lit from the viewer and from above, darker at its edges and with depth.
in vec3 position_mm;
in vec3 normal;

uniform vec3 color;
uniform float opacity;
uniform vec2 depth_range_mm;  // Nearest and farthest of what is drawn.

out vec4 pixel;  // Premultiplied.

const vec3 kKeyLight = vec3(-0.40, -0.66, -0.64);  // From the upper left, camera frame.
const float kGloss = 0.16;

void main() {
  vec3 to_viewer = -position_mm * inversesqrt(dot(position_mm, position_mm));
  vec3 n = normal * inversesqrt(max(dot(normal, normal), 1e-12));
  float facing = dot(n, to_viewer);
  n *= facing < 0.0 ? -1.0 : 1.0;  // The inside of an open surface.
  facing = abs(facing);
  float key = max(dot(n, kKeyLight), 0.0);
  float gloss = kGloss * pow(max(dot(n, normalize(kKeyLight + to_viewer)), 0.0), 24.0);
  float light = 0.14 + 0.55 * facing + 0.42 * key;
  float edge = smoothstep(0.0, 0.55, facing);
  float depth = clamp((position_mm.z - depth_range_mm.x) / (depth_range_mm.y - depth_range_mm.x), 0.0, 1.0);
  vec3 shade = mix(vec3(1.0), vec3(0.42, 0.47, 0.56), depth) * mix(0.30, 1.0, edge);
  // A wall that turns away is looked through for longer.
  float alpha = opacity >= 1.0 ? 1.0 : 1.0 - pow(1.0 - opacity, 1.0 / max(facing, 0.2));
  pixel = vec4(color * (light * shade + gloss) * alpha, alpha);
}

#version 330 core
// The CT skin to be met by the body in the picture: glass, bright where it turns away.
in vec3 position_mm;
in vec3 normal;

uniform vec3 color;

out vec4 pixel;  // Premultiplied.

void main() {
  vec3 to_viewer = -position_mm * inversesqrt(dot(position_mm, position_mm));
  float facing = abs(dot(normal, to_viewer)) * inversesqrt(max(dot(normal, normal), 1e-12));
  float outline = 1.0 - smoothstep(0.0, 0.62, facing);
  float alpha = mix(0.22, 0.95, outline);
  pixel = vec4(color * mix(0.35 + 0.5 * facing, 1.0, outline) * alpha, alpha);
}

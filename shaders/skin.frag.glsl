#version 330 core
// The CT skin in the colours of a camera's picture (paper, equations 3 and 4) or of an atlas. What has
// no colour is cut away, or shown as bare.
in vec3 position_mm;  // Of the virtual camera.
in vec3 normal;
in vec2 atlas_place;  // 0..1.

const int kNone = 0;
const int kPicture = 1;
const int kAtlas = 2;
uniform int source;
uniform bool shows_bare;
uniform sampler2D colors;  // Alpha: what is to be seen of the colour.

uniform mat4 color_from_view;
uniform vec2 picture_focal;   // From (x/z, y/z) to 0..1 of the picture.
uniform vec2 picture_center;
uniform float picture_distortion[5];  // k1, k2, p1, p2, k3.
uniform float picture_max_radius_sq;  // Of (x/z, y/z) that the distortion bears; 0: no distortion.
uniform vec2 picture_margin;          // Half a pixel.
uniform sampler2D seen_mm;            // How deep the colour camera sees, a pinhole's picture.
uniform vec2 seen_focal_px;
uniform vec2 seen_center_px;

out vec4 pixel;  // Premultiplied.

// Cosines between which the picture fades: from 86 degrees on a pixel of it covers fifteen of the skin.
const float kLeastFacing = 0.07;
const float kFullFacing = 0.18;
const float kBareHatchPx = 9.0;

vec2 distorted(vec2 ray) {
  float r2 = dot(ray, ray);
  float radial = 1.0 + r2 * (picture_distortion[0] + r2 * (picture_distortion[1] + r2 * picture_distortion[4]));
  float p1 = picture_distortion[2];
  float p2 = picture_distortion[3];
  return ray * radial + vec2(2.0 * p1 * ray.x * ray.y + p2 * (r2 + 2.0 * ray.x * ray.x),
                             p1 * (r2 + 2.0 * ray.y * ray.y) + 2.0 * p2 * ray.x * ray.y);
}

// Share of the four places around the ray at which the point is before what the colour camera sees: its
// half is the edge.
float seen_share(vec2 ray, float z) {
  ivec2 size = textureSize(seen_mm, 0);
  vec2 at = seen_focal_px * ray + seen_center_px;
  ivec2 first = ivec2(floor(at));
  if (first.x < 0 || first.y < 0 || first.x + 1 >= size.x || first.y + 1 >= size.y) return 0.0;
  vec4 limits_mm = vec4(texelFetch(seen_mm, first, 0).r, texelFetch(seen_mm, first + ivec2(1, 0), 0).r,
                        texelFetch(seen_mm, first + ivec2(0, 1), 0).r, texelFetch(seen_mm, first + ivec2(1, 1), 0).r);
  vec4 is_seen = vec4(lessThan(vec4(z), limits_mm));
  vec2 share = at - vec2(first);
  vec2 columns = mix(is_seen.xz, is_seen.yw, share.x);
  return mix(columns.x, columns.y, share.y);
}

vec4 color_of_picture() {
  vec3 place = (color_from_view * vec4(position_mm, 1.0)).xyz;
  if (place.z < 1.0) return vec4(0.0);
  vec3 turned = mat3(color_from_view) * normal;
  float facing = -dot(turned, place) * inversesqrt(max(dot(turned, turned) * dot(place, place), 1e-12));
  if (facing < kLeastFacing) return vec4(0.0);
  vec2 ray = place.xy / place.z;
  if (picture_max_radius_sq > 0.0 && dot(ray, ray) > picture_max_radius_sq) return vec4(0.0);
  vec2 at = picture_focal * (picture_max_radius_sq > 0.0 ? distorted(ray) : ray) + picture_center;
  if (any(lessThan(at, picture_margin)) || any(greaterThan(at, 1.0 - picture_margin))) return vec4(0.0);
  vec4 color = texture(colors, at);
  return vec4(color.rgb, color.a * seen_share(ray, place.z) * smoothstep(kLeastFacing, kFullFacing, facing));
}

// Matt and hatched: nobody may take it for a picture.
vec3 bare() {
  vec3 to_viewer = -position_mm * inversesqrt(dot(position_mm, position_mm));
  float facing = abs(dot(normal, to_viewer)) * inversesqrt(max(dot(normal, normal), 1e-12));
  float along = mod(gl_FragCoord.x + gl_FragCoord.y, kBareHatchPx);
  float hatch = along < 2.0 ? 0.72 : 1.0;
  return vec3(0.40, 0.45, 0.52) * (0.25 + 0.75 * facing) * hatch;
}

void main() {
  vec4 color = vec4(0.0);
  if (source == kPicture) color = color_of_picture();
  if (source == kAtlas) color = texture(colors, atlas_place);
  if (shows_bare) {
    pixel = vec4(mix(bare(), color.rgb, color.a), 1.0);
    return;
  }
  if (color.a < 0.01) discard;
  pixel = vec4(color.rgb * color.a, color.a);
}

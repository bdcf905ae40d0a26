#version 330 core
// What ray_caster.cc does on a CPU, a ray a pixel: front to back through the volume and the layers, a sample a voxel,
// transparent bricks leapt over. A test holds the two together.
uniform sampler2D rays;            // x/z, y/z, and z from which and up to which it is looked at.
uniform sampler2DArray colors;     // What else the ray meets, nearest first, premultiplied;
uniform sampler2DArray depths;     // its z. A huge one: nothing more.
uniform int num_layers;
uniform sampler3D voxels;          // HU / 32767.
uniform usampler3D bricks;         // Distance to the nearest brick of which something is seen; 0: this one.
uniform sampler2D table;           // 64 entries a row: opacity, its sum, its moment's sum.
uniform sampler2D table_colors;
uniform float surface_entry;
uniform ivec3 size;
uniform vec3 eye;                  // In voxels.
uniform mat3 voxels_from_ray;
uniform mat3 color_from_gradient;
uniform vec3 gradient_voxels;
uniform vec2 body_mm;              // z of the volume's nearest and farthest corner.
uniform float step_length_mm;

out vec4 pixel;

const float kBrick = 8.0;
const float kEnough = 0.98;
const float kLeastOpacity = 0.002;
const float kLeastLit = 0.01;
const vec3 kKeyLight = vec3(-0.40, -0.66, -0.64);
const float kFlatLight = 0.80;
const float kNoDepth = 3.0e38;

float hu_at(vec3 place) {
  return texture(voxels, (clamp(place, vec3(0.0), vec3(size) - 1.001) + 0.5) / vec3(size)).r * 32767.0;
}

int entry_at(vec3 place) { return int(clamp(hu_at(place), -1024.0, 3071.0) + 1024.5); }
vec3 entry_of(int entry) { return texelFetch(table, ivec2(entry & 63, entry >> 6), 0).rgb; }

float darkening(float depth_mm) {
  return mix(1.0, 0.62, clamp((depth_mm - body_mm.x) / (body_mm.y - body_mm.x), 0.0, 1.0));
}

float light_of(vec3 place, vec3 towards, float depth_mm) {
  vec3 reach = gradient_voxels;
  float a = hu_at(place + vec3(1, -1, -1) * reach);
  float b = hu_at(place + vec3(-1, -1, 1) * reach);
  float c = hu_at(place + vec3(-1, 1, -1) * reach);
  float d = hu_at(place + reach);
  vec3 n = color_from_gradient * (vec3(a - b - c + d, c + d - a - b, b + d - a - c) * 0.25 / reach);
  float steepness = length(n) + 1e-3;
  float to_viewer = dot(n, towards) / steepness;
  float key = -dot(n, kKeyLight) / steepness * (to_viewer < 0.0 ? -1.0 : 1.0);
  float facing = abs(to_viewer);
  float edge = min(0.45 + 0.55 / 0.4 * facing, 1.0);
  float lit = (0.16 + 0.56 * facing + 0.45 * max(key, 0.0)) * edge;
  return mix(kFlatLight, lit, clamp((steepness - 15.0) / 65.0, 0.0, 1.0)) * darkening(depth_mm);
}

void main() {
  vec4 ray = texelFetch(rays, ivec2(gl_FragCoord.xy), 0);
  vec3 direction = vec3(ray.xy, 1.0);
  vec3 per_mm = voxels_from_ray * direction;
  vec3 towards = normalize(direction);
  float step_mm = step_length_mm / length(direction);
  vec3 inverse = 1.0 / mix(per_mm, vec3(1e-6), lessThan(abs(per_mm), vec3(1e-6)));
  vec3 one = -eye * inverse;
  vec3 other = (vec3(size) - 1.0 - eye) * inverse;
  vec3 enters = min(one, other);
  vec3 leaves = max(one, other);
  float first_mm = max(ray.z, max(enters.x, max(enters.y, enters.z)));
  float last_mm = min(ray.w, min(leaves.x, min(leaves.y, leaves.z)));
  first_mm = ray.z >= kNoDepth ? kNoDepth : first_mm + 0.5 * step_mm;

  vec4 seen = vec4(0.0);  // Premultiplied.
  int next = 0;
  int before = 0;
  bool is_stale = true;
  bool is_inside = false;
  float light = 0.0;
  for (int layer = 0; layer <= num_layers; ++layer) {
    float limit_mm = last_mm;
    float layer_mm = kNoDepth;
    if (layer < num_layers) {
      layer_mm = texelFetch(depths, ivec3(gl_FragCoord.xy, layer), 0).r;
      limit_mm = min(limit_mm, layer_mm);
    }
    while (seen.a < kEnough) {
      float depth_mm = first_mm + float(next) * step_mm;
      if (!(depth_mm < limit_mm)) break;
      vec3 place = eye + depth_mm * per_mm;
      ivec3 brick = clamp(ivec3(place / kBrick), ivec3(0), textureSize(bricks, 0) - 1);
      int distance = int(texelFetch(bricks, brick, 0).r);
      ++next;
      if (distance > 0) {
        ivec3 border = ivec3(per_mm.x > 0.0 ? brick.x + distance : brick.x - distance + 1,
                             per_mm.y > 0.0 ? brick.y + distance : brick.y - distance + 1,
                             per_mm.z > 0.0 ? brick.z + distance : brick.z - distance + 1);
        vec3 exits = (vec3(border) * kBrick - eye) * inverse;
        exits = mix(exits, vec3(kNoDepth), lessThan(abs(per_mm), vec3(1e-6)));
        float end_mm = min(limit_mm, min(exits.x, min(exits.y, exits.z)));
        next = max(next, int((end_mm - first_mm) / step_mm - 1e-3) + 1);
        is_stale = true;
        continue;
      }
      int entry = entry_at(place);
      if (is_stale) before = entry_at(eye + (depth_mm - step_mm) * per_mm);
      int last = before;
      before = entry;
      is_stale = false;
      vec3 here = entry_of(entry);
      vec3 sum = here - entry_of(last);
      float opacity = entry == last ? here.x : sum.y / float(entry - last);
      bool is_dense = float(entry) > surface_entry;
      bool goes_on = is_dense && is_inside;
      if (!(opacity > kLeastOpacity)) {
        is_inside = false;
        continue;
      }
      float share = opacity * (1.0 - seen.a);
      if (!goes_on) {
        if (share > kLeastLit) {
          bool comes_in = float(last) < surface_entry && float(entry) > surface_entry;
          float back = comes_in ? (float(entry) - surface_entry) / float(entry - last) : 0.0;
          float lit_mm = depth_mm - back * step_mm;
          light = light_of(eye + lit_mm * per_mm, towards, lit_mm);
        } else {
          light = kFlatLight * darkening(depth_mm);
        }
      }
      is_inside = is_dense;
      float middle = clamp(sum.z / (sum.y == 0.0 ? 1.0 : sum.y), float(min(entry, last)), float(max(entry, last)));
      int shown = int(middle + 0.5);
      vec3 color = texelFetch(table_colors, ivec2(shown & 63, shown >> 6), 0).rgb;
      seen += vec4(min(color * light, vec3(2.0)), 1.0) * share;
    }
    if (layer_mm < kNoDepth) seen += texelFetch(colors, ivec3(gl_FragCoord.xy, layer), 0) * (1.0 - seen.a);
  }
  pixel = seen;
}

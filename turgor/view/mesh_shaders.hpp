// GLSL programs of mesh pictures (deferred shading). The G-buffer stores visible surfaces per sample and is
// lit into a linear picture. Ambient occlusion is estimated from the depths [McGuire, Mara, Luebke 2012].
// Both are composed over the background and converted to sRGB.
#pragma once

namespace turgor {

// Vertex shaders of surfaces are compiled twice; with CUT they draw one side of a plane only. (Mesa 22 clips
// wrongly where a shader writes clip distances that are not enabled.)
constexpr const char* kShadowVertexShader = R"(#version 330 core
layout(location = 0) in vec3 position;
uniform mat4 to_clip;

#ifdef CUT
uniform vec4 kept_side;
#endif

void main() {
  gl_Position = to_clip * vec4(position, 1);
#ifdef CUT
  gl_ClipDistance[0] = dot(kept_side, vec4(position, 1));
#endif
}
)";

constexpr const char* kShadowFragmentShader = R"(#version 330 core
void main() {}
)";

constexpr const char* kSurfaceVertexShader = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 color;
layout(location = 3) in float fraction;
uniform mat4 to_clip;
uniform vec3 eye;
#ifdef CUT
uniform vec4 kept_side, picture_right, picture_up;
out vec2 at_picture;
#endif
invariant gl_Position;  // see-through surfaces and cut faces are drawn twice
out vec3 to_eye;
out vec3 surface_normal;
out vec3 surface_color;
out float map_fraction;

void main() {
  gl_Position = to_clip * vec4(position, 1);
#ifdef CUT
  gl_ClipDistance[0] = dot(kept_side, vec4(position, 1));
  at_picture = vec2(dot(picture_right, vec4(position, 1)), dot(picture_up, vec4(position, 1)));
#endif
  to_eye = eye - position;
  surface_normal = normal;
  surface_color = pow(color, vec3(2.2));
  map_fraction = fraction;
}
)";

// Writes the G-buffer: the color (square root of the albedo) with its source (1 own color, 2 color map, 3 own
// color of a wet surface), and the normal in the camera frame with octahedral encoding [Cigolle et al. 2014].
// Lighting is deferred because triangles are small and many.
constexpr const char* kSurfaceFragmentShader = R"(#version 330 core
in vec3 to_eye;
in vec3 surface_normal;
in vec3 surface_color;
in float map_fraction;
uniform sampler2D color_map;
uniform bool use_map, wet;
uniform vec3 right_axis, up, back_axis;
#ifdef CUT
in vec2 at_picture;
uniform sampler2D face_picture;
uniform bool use_picture;
#endif
layout(location = 0) out uint packed_color;
layout(location = 1) out uint packed_normal;

void main() {
  vec3 face = cross(dFdx(to_eye), dFdy(to_eye));
  if (dot(face, to_eye) < 0.0) face = -face;
  vec3 n = surface_normal;
  if (dot(n, face) < 0.0) n = -n;  // the visible side
  n = vec3(dot(right_axis, n), dot(up, n), dot(back_axis, n));
  n /= abs(n.x) + abs(n.y) + abs(n.z);
  vec2 folded = (1.0 - abs(n.yx)) * mix(vec2(-1), vec2(1), greaterThanEqual(n.xy, vec2(0)));
  uvec2 at = uvec2(32767.5 + 32767.0 * (n.z >= 0.0 ? n.xy : folded));

  bool mapped = use_map && !isnan(map_fraction);
  vec3 albedo = surface_color;
  if (mapped) {
    float texel = clamp(map_fraction, 0.0, 1.0) * 255.0 + 0.5;
    albedo = pow(texture(color_map, vec2(texel / 256.0, 0.5)).rgb, vec3(2.2));
  }
#ifdef CUT
  if (use_picture) albedo = pow(texture(face_picture, at_picture).rgb, vec3(2.2));
#endif
  uvec3 c = uvec3(0.5 + 255.0 * sqrt(clamp(albedo, 0.0, 1.0)));
  packed_color = c.r | c.g << 8 | c.b << 16 | (mapped ? 2u : wet ? 3u : 1u) << 24;
  packed_normal = at.x | at.y << 16;
}
)";

// Lighting of the G-buffer; a main function follows, and before it, if it needs one, a definition of
// surface_light.
constexpr const char* kLighting = R"(#version 330 core
in vec2 uv;
uniform int samples;
uniform vec2 tan_half;  // half the view at unit depth
uniform vec3 right_axis, up, back_axis;
uniform vec3 key, fill, rim;
uniform vec3 key_color, fill_color, rim_color, sky_color, floor_color;

vec4 color_of(uint c) { return vec4(uvec4(c, c >> 8, c >> 16, c >> 24) & 255u) / vec4(255, 255, 255, 1); }

// In the camera frame, not normalized.
vec3 normal_of(uint packed_normal) {
  vec2 at = vec2(uvec2(packed_normal, packed_normal >> 16) & 65535u) / 32767.0 - 1.0;
  vec3 n = vec3(at, 1.0 - abs(at.x) - abs(at.y));
  n.xy += mix(vec2(1), vec2(-1), greaterThanEqual(n.xy, vec2(0))) * max(0.0, -n.z);
  return n;
}

vec3 world_normal(vec3 view_normal) {
  view_normal = normalize(view_normal);
  return view_normal.x * right_axis + view_normal.y * up + view_normal.z * back_axis;
}

float depth_of(float d, vec2 near_far) {
  d = d * 2.0 - 1.0;
  return 2.0 * near_far.x * near_far.y / (near_far.y + near_far.x - d * (near_far.y - near_far.x));
}

vec3 ray_of_pixel() {
  vec2 at = (2.0 * uv - 1.0) * tan_half;
  return at.x * right_axis + at.y * up - back_axis;
}

vec3 lit_surface(vec4 color, vec3 n, vec3 view, float open) {
  vec3 albedo = color.rgb * color.rgb;
  bool mapped = color.a > 1.5;
  // Subsurface scattering in skin: the terminator is soft, and softest in red.
  vec3 wrap = mapped ? vec3(0.25) : vec3(0.32, 0.20, 0.15);
  float towards = dot(n, key);
  float share = mix(1.0, 0.12 + 0.88 * open, smoothstep(0.0, 0.3, towards));  // the terminator is soft already
  vec3 lit = key_color * share * max(vec3(0), (towards + wrap) / (1.0 + wrap));
  lit += fill_color * max(0.0, dot(n, fill)) + mix(floor_color, sky_color, 0.5 + 0.5 * dot(n, up));
  float grazing = 1.0 - max(0.0, dot(n, view));
  grazing *= grazing, grazing *= grazing;
  vec3 shine = rim_color * (grazing * (0.15 + 0.65 * max(0.0, dot(n, rim))));
  float half_angle = max(0.0, dot(n, normalize(key + view)));
  shine += share * key_color * (0.05 * pow(half_angle, 22.0) + 0.035 * pow(half_angle, 90.0));
  return albedo * lit * (mapped ? 1.12 : 1.0) + shine * (mapped ? 0.35 : 0.6);
}
)";

constexpr const char* kDryLight = R"(
vec3 surface_light(vec4 color, vec3 n, vec3 view, float open) { return lit_surface(color, n, view, open); }
)";
constexpr const char* kWetLight = R"(
vec3 surface_light(vec4 color, vec3 n, vec3 view, float open) { return wet_surface(color, n, view, open); }
)";
constexpr const char* kEitherLight = R"(
vec3 surface_light(vec4 color, vec3 n, vec3 view, float open) {
  return color.a > 2.5 ? wet_surface(color, n, view, open) : lit_surface(color, n, view, open);
}
)";

// Resolves several samples per pixel to one and writes a level that selects the lighting. Pixels whose
// samples share normal and source are lit once, edges per sample, empty pixels not at all. Levels are depth
// values, because a depth test spares a software renderer the other pixels and a branch does not.
constexpr const char* kResolveMain = R"(
uniform usampler2DMS colors, normals;
uniform sampler2DMS depths;
uniform vec2 near_far;
uniform vec2 smooth_levels, edge_levels;  // of dry and wet surfaces
layout(location = 0) out vec4 color;  // and a quarter of its color source
layout(location = 1) out vec4 view_normal;
layout(location = 2) out float view_depth;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 sum = vec4(0);
  vec3 normal = vec3(0);
  float covered = 0.0, nearest = 1.0, middle = 0.0;
  uint least = 255u, most = 0u;  // color sources
  for (int s = 0; s < samples; s++) {
    uint c = texelFetch(colors, pixel, s).r;
    float covers = c == 0u ? 0.0 : 1.0;
    sum += covers * color_of(c);
    normal += covers * normalize(normal_of(texelFetch(normals, pixel, s).r));
    covered += covers;
    least = min(least, c >> 24), most = max(most, c >> 24);
    float depth = texelFetch(depths, pixel, s).r;
    nearest = min(nearest, depth);
    middle += depth / float(samples);
  }
  bool is_edge = least != most || length(normal) < 0.995 * covered;
  vec2 levels = is_edge ? edge_levels : smooth_levels;
  gl_FragDepth = covered == 0.0 ? 1.0 : most == 3u ? levels.y : levels.x;
  color = vec4(sum.rgb, 0.25 * sum.a) / max(covered, 1.0);
  view_normal = vec4(0.5 + 0.5 * normalize(normal + vec3(0, 0, 1e-6)), 1);
  view_depth = depth_of(is_edge ? nearest : middle, near_far);
}
)";

// Visible fraction of the key light at a position: a mean over a disc, which gives soft shadow edges.
constexpr const char* kKeyShare = R"(
uniform sampler2DShadow shadow;
uniform mat4 to_light;
uniform float shadow_texel;  // [m]
uniform vec3 eye;
layout(location = 0) out vec4 light;

float key_share(vec3 position, vec3 n) {
  vec4 in_light = to_light * vec4(position + 2.5 * shadow_texel * n, 1);
  vec3 at = 0.5 + 0.5 * in_light.xyz;
  float sum = 0.0;
  for (int i = 0; i < 8; i++) {
    float radius = 5.0 / 2048.0 * sqrt((float(i) + 0.5) / 8.0), angle = 2.39996 * float(i);
    sum += texture(shadow, vec3(at.xy + radius * vec2(cos(angle), sin(angle)), at.z));
  }
  return sum / 8.0;
}

vec3 lit_position(vec4 color, vec3 view_normal, vec3 ray, float depth) {
  vec3 n = world_normal(view_normal);
  return surface_light(color, n, -normalize(ray), key_share(eye + ray * depth, n));
}
)";

constexpr const char* kSmoothMain = R"(
uniform sampler2D resolved_colors, resolved_normals, resolved_depths;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 color = texelFetch(resolved_colors, pixel, 0);
  vec3 view_normal = 2.0 * texelFetch(resolved_normals, pixel, 0).rgb - 1.0;
  float depth = texelFetch(resolved_depths, pixel, 0).r;
  light = vec4(lit_position(vec4(color.rgb, 4.0 * color.a), view_normal, ray_of_pixel(), depth), 1);
}
)";

constexpr const char* kEdgeMain = R"(
uniform usampler2DMS colors, normals;
uniform sampler2DMS depths;
uniform vec2 near_far;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec3 ray = ray_of_pixel();
  vec4 sum = vec4(0);
  for (int s = 0; s < samples; s++) {
    uint c = texelFetch(colors, pixel, s).r;
    float depth = depth_of(texelFetch(depths, pixel, s).r, near_far);
    vec3 lit = lit_position(color_of(c), normal_of(texelFetch(normals, pixel, s).r), ray, depth);
    if (c != 0u) sum += vec4(lit, 1);
  }
  light = sum / float(samples);
}
)";

// See-through surfaces behind others, blended over the light of those. Tissue in front tints, absorbs and
// scatters their light: they fade with depth and towards their contours, so that they read as inside.
constexpr const char* kInnerMain = R"(
uniform usampler2DMS colors, normals, outer;
uniform sampler2DMS depths, nearer;
uniform vec2 near_far;
uniform float through;     // largest share of their light
uniform float absorption;  // depth of tissue that reduces it to 1/e [m]
layout(location = 0) out vec4 light;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec3 view = -normalize(ray_of_pixel());
  vec4 sum = vec4(0);
  for (int s = 0; s < samples; s++) {
    uint c = texelFetch(colors, pixel, s).r;
    if (c == 0u) continue;
    float depth = texelFetch(depths, pixel, s).r, front = texelFetch(nearer, pixel, s).r;
    if (depth <= front) continue;
    vec3 n = world_normal(normal_of(texelFetch(normals, pixel, s).r));
    vec3 tissue = color_of(texelFetch(outer, pixel, s).r).rgb;
    vec3 tint = mix(vec3(1), tissue / max(0.01, max(tissue.r, max(tissue.g, tissue.b))), 0.6);
    float behind = depth_of(depth, near_far) - depth_of(front, near_far);
    float share = through * (0.25 + 0.75 * exp(-behind / absorption)) * smoothstep(0.0, 0.9, abs(dot(n, view)));
    sum += share * vec4(tint * lit_surface(color_of(c), n, view, 1.0), 1);
  }
  light = sum / float(samples);
}
)";

constexpr const char* kScreenVertexShader = R"(#version 330 core
uniform float level;  // a depth
out vec2 uv;

void main() {
  uv = vec2(gl_VertexID == 1 ? 2.0 : 0.0, gl_VertexID == 2 ? 2.0 : 0.0);
  gl_Position = vec4(2.0 * uv - 1.0, 2.0 * level - 1.0, 1);
}
)";

constexpr const char* kOcclusionFragmentShader = R"(#version 330 core
in vec2 uv;
uniform sampler2D depths, normals;
uniform vec2 tan_half;   // half the view at unit depth
uniform float reach;     // occlusion radius, as a fraction of the picture's height
layout(location = 0) out vec2 openness;  // and the depth

const int kSamples = 18;

vec3 view_point(vec2 at) {
  float z = texture(depths, at).r;
  return vec3((2.0 * at - 1.0) * tan_half * z, -z);
}

void main() {
  vec4 stored = texture(normals, uv);
  vec3 p = view_point(uv), n = normalize(2.0 * stored.rgb - 1.0);
  float radius = reach * 2.0 * tan_half.y * -p.z, radius2 = radius * radius, sum = 0.0;
  ivec2 pixel = ivec2(gl_FragCoord.xy) & 3;
  float phase = 0.3927 * float((pixel.x * 5 + pixel.y * 7) & 15);
  float aspect = tan_half.x / tan_half.y;
  for (int i = 0; i < kSamples; i++) {
    float share = (float(i) + 0.5) / float(kSamples), angle = 2.39996 * float(i) + phase;
    vec2 offset = reach * share * share * vec2(cos(angle) / aspect, sin(angle));
    vec3 v = view_point(uv + offset) - p;
    float vv = dot(v, v), f = max(0.0, radius2 - vv);
    sum += f * f * f * max(0.0, dot(v, n) - 0.002 * -p.z) / (vv + 0.0004 * radius2);
  }
  float occlusion = sum * 4.0 * radius / (radius2 * radius2 * radius2 * float(kSamples));
  openness = vec2(max(0.0, 1.0 - occlusion), -p.z);
}
)";

constexpr const char* kPictureFragmentShader = R"(#version 330 core
in vec2 uv;
uniform sampler2D lights, occlusions;
uniform vec3 backdrop_center, backdrop_edge;
uniform float shoulder;
layout(location = 0) out vec4 picture;

// Mean of the 4 x 4 surrounding pixels of similar depth: the sample pattern repeats every 4 pixels.
float smooth_openness() {
  ivec2 last = textureSize(occlusions, 0) - 1, pixel = ivec2(gl_FragCoord.xy);
  float center_depth = texelFetch(occlusions, pixel, 0).g, sum = 0.0, weights = 0.0;
  for (int y = -2; y < 2; y++) {
    for (int x = -2; x < 2; x++) {
      vec2 open = texelFetch(occlusions, clamp(pixel + ivec2(x, y), ivec2(0), last), 0).rg;
      float weight = abs(open.g - center_depth) < 0.02 * center_depth ? 1.0 : 0.001;
      sum += weight * open.r;
      weights += weight;
    }
  }
  return sum / weights;
}

vec3 screen(vec3 linear) {
  vec3 over = (max(linear, shoulder) - shoulder) / (1.0 - shoulder);
  vec3 e = exp(-2.0 * over);
  vec3 rolled = min(linear, shoulder) + (1.0 - shoulder) * (1.0 - e) / (1.0 + e);
  return mix(12.92 * rolled, 1.055 * pow(rolled, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, rolled));
}

void main() {
  vec2 d = vec2(uv.x - 0.5, (1.0 - uv.y) - 0.42);
  vec3 behind = mix(backdrop_center, backdrop_edge, min(1.0, 1.9 * dot(d, d)));
  vec4 light = texelFetch(lights, ivec2(gl_FragCoord.xy), 0);
  float open = light.a > 0.0 ? smooth_openness() : 1.0;
  // Remaining light in a hollow was reflected by the surface: it is darker, and a little redder.
  vec3 left = mix(vec3(0.34, 0.26, 0.25), vec3(1), open);
  picture = vec4(screen(light.rgb * left + behind * (1.0 - light.a)), 1);
}
)";

}  // namespace turgor

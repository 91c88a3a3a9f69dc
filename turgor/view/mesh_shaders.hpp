// The GLSL programs of mesh pictures. Three passes: surfaces are lit into a linear picture and their normals
// kept; the occlusion of each pixel by its surroundings is estimated from the depths [McGuire, Mara, Luebke
// 2012]; both are put before the backdrop and turned into what screens show.
#pragma once

namespace turgor {

constexpr const char* kShadowVertexShader = R"(#version 330 core
layout(location = 0) in vec3 position;
uniform mat4 to_clip;
invariant gl_Position;

void main() { gl_Position = to_clip * vec4(position, 1); }
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
invariant gl_Position;
out vec3 to_eye;
out vec3 surface_normal;
out vec3 surface_color;
out float map_fraction;

void main() {
  gl_Position = to_clip * vec4(position, 1);
  to_eye = eye - position;
  surface_normal = normal;
  surface_color = pow(color, vec3(2.2));
  map_fraction = fraction;
}
)";

constexpr const char* kSurfaceFragmentShader = R"(#version 330 core
in vec3 to_eye;
in vec3 surface_normal;
in vec3 surface_color;
in float map_fraction;
uniform sampler2D color_map;
uniform bool use_map;
uniform sampler2DShadow shadow;
uniform mat4 to_light;
uniform float shadow_texel;  // [m]
uniform vec3 eye, right_axis, back_axis;
uniform bool through;  // inside of another surface, whose shadow does not count
uniform vec3 key, fill, rim, up;
uniform vec3 key_color, fill_color, rim_color, sky_color, floor_color;
layout(location = 0) out vec4 light;
layout(location = 1) out vec4 view_normal;

// How much of the key light reaches the place: a mean over a disc, so that shadows have soft rims.
float key_share(vec3 position, vec3 n) {
  vec4 place = to_light * vec4(position + 2.5 * shadow_texel * n, 1);
  vec3 at = 0.5 + 0.5 * place.xyz;
  float sum = 0.0;
  for (int i = 0; i < 8; i++) {
    float radius = 5.0 / 2048.0 * sqrt((float(i) + 0.5) / 8.0), angle = 2.39996 * float(i);
    sum += texture(shadow, vec3(at.xy + radius * vec2(cos(angle), sin(angle)), at.z));
  }
  return sum / 8.0;
}

void main() {
  vec3 view = normalize(to_eye);
  vec3 face = cross(dFdx(to_eye), dFdy(to_eye));
  if (dot(face, view) < 0.0) face = -face;
  vec3 n = normalize(surface_normal);
  if (dot(n, face) < 0.0) n = -n;  // the side that is seen

  bool mapped = use_map && !isnan(map_fraction);
  vec3 albedo = surface_color;
  if (mapped) {
    float texel = clamp(map_fraction, 0.0, 1.0) * 255.0 + 0.5;
    albedo = pow(texture(color_map, vec2(texel / 256.0, 0.5)).rgb, vec3(2.2));
  }

  // Light that enters skin leaves it beside: the terminator is soft, and softest in red.
  vec3 wrap = mapped ? vec3(0.25) : vec3(0.32, 0.20, 0.15);
  float towards = dot(n, key), share = through ? 1.0 : key_share(eye - to_eye, n);
  share = mix(1.0, 0.12 + 0.88 * share, smoothstep(0.0, 0.3, towards));  // the terminator is soft already
  vec3 lit = key_color * share * max(vec3(0), (towards + wrap) / (1.0 + wrap));
  lit += fill_color * max(0.0, dot(n, fill)) + mix(floor_color, sky_color, 0.5 + 0.5 * dot(n, up));
  float grazing = pow(1.0 - max(0.0, dot(n, view)), 4.0);
  vec3 shine = rim_color * (grazing * (0.15 + 0.65 * max(0.0, dot(n, rim))));
  float half_angle = max(0.0, dot(n, normalize(key + view)));
  shine += share * key_color * (0.05 * pow(half_angle, 22.0) + 0.035 * pow(half_angle, 90.0));
  light = vec4(albedo * lit * (mapped ? 1.12 : 1.0) + shine * (mapped ? 0.35 : 0.6), 1);
  view_normal = vec4(0.5 + 0.5 * vec3(dot(right_axis, n), dot(up, n), dot(back_axis, n)), 1);
}
)";

// Pictures that move, where no GPU draws: one pass, lit at the vertices.
constexpr const char* kQuickVertexShader = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 color;
layout(location = 3) in float fraction;
uniform mat4 to_clip;
uniform vec3 eye;
uniform sampler2D color_map;
uniform bool use_map;
uniform vec3 key, fill, up;
uniform vec3 key_color, fill_color, sky_color, floor_color;
out vec3 shown;

void main() {
  gl_Position = to_clip * vec4(position, 1);
  vec3 n = dot(normal, eye - position) < 0.0 ? -normal : normal;
  vec3 albedo = pow(color, vec3(2.2));
  if (use_map && !isnan(fraction))
    albedo = pow(texelFetch(color_map, ivec2(clamp(fraction, 0.0, 1.0) * 255.0 + 0.5, 0), 0).rgb, vec3(2.2));
  vec3 lit = key_color * max(0.0, (dot(n, key) + 0.25) / 1.25) + fill_color * max(0.0, dot(n, fill));
  lit += mix(floor_color, sky_color, 0.5 + 0.5 * dot(n, up));
  shown = pow(min(albedo * lit, 1.0), vec3(1.0 / 2.2));
}
)";

constexpr const char* kQuickFragmentShader = R"(#version 330 core
in vec3 shown;
layout(location = 0) out vec4 picture;

void main() { picture = vec4(shown, 1); }
)";

constexpr const char* kScreenVertexShader = R"(#version 330 core
out vec2 place;

void main() {
  place = vec2(gl_VertexID == 1 ? 2.0 : 0.0, gl_VertexID == 2 ? 2.0 : 0.0);
  gl_Position = vec4(2.0 * place - 1.0, 0, 1);
}
)";

constexpr const char* kOcclusionFragmentShader = R"(#version 330 core
in vec2 place;
uniform sampler2D depths, normals;
uniform vec2 tan_half;   // half the view at unit depth
uniform vec2 near_far;
uniform float reach;     // of the surroundings, as a fraction of the picture's height
layout(location = 0) out vec4 openness;

const int kSamples = 18;

vec3 view_point(vec2 at) {
  float d = texture(depths, at).r * 2.0 - 1.0;
  float z = 2.0 * near_far.x * near_far.y / (near_far.y + near_far.x - d * (near_far.y - near_far.x));
  return vec3((2.0 * at - 1.0) * tan_half * z, -z);
}

void main() {
  openness = vec4(1);
  vec4 stored = texture(normals, place);
  if (stored.a == 0.0) return;
  vec3 p = view_point(place), n = normalize(2.0 * stored.rgb / stored.a - 1.0);
  float radius = reach * 2.0 * tan_half.y * -p.z, radius2 = radius * radius, sum = 0.0;
  ivec2 pixel = ivec2(gl_FragCoord.xy) & 3;
  float phase = 0.3927 * float((pixel.x * 5 + pixel.y * 7) & 15);
  float aspect = tan_half.x / tan_half.y;
  for (int i = 0; i < kSamples; i++) {
    float share = (float(i) + 0.5) / float(kSamples), angle = 2.39996 * float(i) + phase;
    vec2 offset = reach * share * share * vec2(cos(angle) / aspect, sin(angle));
    vec3 v = view_point(place + offset) - p;
    float vv = dot(v, v), f = max(0.0, radius2 - vv);
    sum += f * f * f * max(0.0, dot(v, n) - 0.002 * -p.z) / (vv + 0.0004 * radius2);
  }
  float occlusion = sum * 4.0 * radius / (radius2 * radius2 * radius2 * float(kSamples));
  openness = vec4(max(0.0, 1.0 - occlusion), place, 1);
}
)";

constexpr const char* kPictureFragmentShader = R"(#version 330 core
in vec2 place;
uniform sampler2D lights, occlusions, depths;
uniform vec2 near_far;
uniform vec3 backdrop_centre, backdrop_edge;
uniform float shoulder;
layout(location = 0) out vec4 picture;

float depth_at(ivec2 pixel) {
  float d = texelFetch(depths, pixel, 0).r * 2.0 - 1.0;
  return 2.0 * near_far.x * near_far.y / (near_far.y + near_far.x - d * (near_far.y - near_far.x));
}

// The mean of the 4 x 4 pixels around that lie about as deep: the pattern of the samples repeats every 4 pixels.
float smooth_openness() {
  ivec2 size = textureSize(depths, 0), pixel = ivec2(gl_FragCoord.xy);
  float here = depth_at(pixel), sum = 0.0, weights = 0.0;
  for (int y = -2; y < 2; y++) {
    for (int x = -2; x < 2; x++) {
      ivec2 at = clamp(pixel + ivec2(x, y), ivec2(0), size - 1);
      float weight = abs(depth_at(at) - here) < 0.02 * here ? 1.0 : 0.001;
      sum += weight * texelFetch(occlusions, at, 0).r;
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
  vec2 d = vec2(place.x - 0.5, (1.0 - place.y) - 0.42);
  vec3 behind = mix(backdrop_centre, backdrop_edge, min(1.0, 1.9 * dot(d, d)));
  vec4 light = texelFetch(lights, ivec2(gl_FragCoord.xy), 0);
  float open = light.a > 0.0 ? smooth_openness() : 1.0;
  // What little light is left in a hollow has been reflected by the surface: it is darker, and a little redder.
  vec3 left = mix(vec3(0.34, 0.26, 0.25), vec3(1), open);
  picture = vec4(screen(light.rgb * left + behind * (1.0 - light.a)), 1);
}
)";

}  // namespace turgor

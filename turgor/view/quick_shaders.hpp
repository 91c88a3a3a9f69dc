// GLSL programs of moving pictures without a GPU: one pass with lighting per vertex. They have
// no highlights, which would look coarse and cost a quarter of the time.
#pragma once

namespace turgor {

constexpr const char* kQuickVertexShader = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 color;
layout(location = 3) in float fraction;
uniform mat4 to_clip;
uniform vec3 eye;
#ifdef CUT
uniform vec4 kept_side, picture_right, picture_up;
out vec2 at_picture;
out vec3 picture_light;
#endif
uniform sampler2D color_map;
uniform bool use_map;
uniform vec3 key, fill, up;
uniform vec3 key_color, fill_color, sky_color, floor_color;
uniform float through;  // share of light that reaches the eye, 1 for opaque surfaces
out vec4 shown;

void main() {
  gl_Position = to_clip * vec4(position, 1);
#ifdef CUT
  gl_ClipDistance[0] = dot(kept_side, vec4(position, 1));
  at_picture = vec2(dot(picture_right, vec4(position, 1)), dot(picture_up, vec4(position, 1)));
#endif
  vec3 n = dot(normal, eye - position) < 0.0 ? -normal : normal;
  vec3 albedo = pow(color, vec3(2.2));
  if (use_map && !isnan(fraction))
    albedo = pow(texelFetch(color_map, ivec2(clamp(fraction, 0.0, 1.0) * 255.0 + 0.5, 0), 0).rgb, vec3(2.2));
  vec3 lit = key_color * max(0.0, (dot(n, key) + 0.25) / 1.25) + fill_color * max(0.0, dot(n, fill));
  lit += mix(floor_color, sky_color, 0.5 + 0.5 * dot(n, up));
#ifdef CUT
  picture_light = lit;
#endif
  float facing = abs(dot(n, normalize(eye - position)));
  shown = vec4(pow(min(albedo * lit, 1.0), vec3(1.0 / 2.2)), through < 1.0 ? through * smoothstep(0.0, 0.9, facing) : 1.0);
}
)";

constexpr const char* kQuickFragmentShader = R"(#version 330 core
in vec4 shown;
#ifdef CUT
in vec2 at_picture;
in vec3 picture_light;
uniform sampler2D face_picture;
uniform bool use_picture;
#endif
layout(location = 0) out vec4 picture;

void main() {
  picture = shown;
#ifdef CUT
  if (use_picture) {
    vec3 albedo = pow(texture(face_picture, at_picture).rgb, vec3(2.2));
    picture.rgb = pow(min(albedo * picture_light, 1.0), vec3(1.0 / 2.2));
  }
#endif
}
)";

}  // namespace turgor

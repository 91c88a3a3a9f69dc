// Reflection of wet tissue: a clear film of water over a scattering base. The film has two GGX lobes [Walter
// et al. 2007] with height-correlated masking [Heitz 2014, eq. 99] and Schlick's Fresnel factor: a narrow
// lobe of the smooth film and a broad one of the relief under it. The base receives the light that the film
// transmits. One source is compiled for the processor (tests) and for OpenGL.
#pragma once

#include <cmath>

namespace turgor {

// Member functions of a struct, and the same text as GLSL.
#define TURGOR_SHADER_SOURCE(Type, ...)                  \
  struct Type {                                          \
    __VA_ARGS__                                          \
    static constexpr const char* kSource = #__VA_ARGS__; \
  };

// clang-format off
TURGOR_SHADER_SOURCE(WetReflection,
  // Fresnel factor of water in air, n = 1.333: ((n − 1) / (n + 1))² at normal incidence [Schlick 1994].
  float wet_fresnel(float cosine) {
    float left = 1.0f - cosine;
    float square = left * left;
    return 0.0204f + 0.9796f * square * square * left;
  }

  // D G / (4 (n·l) (n·v)) of the GGX distribution with roughness alpha [1/sr]; n·h, n·l and n·v are cosines
  // between normal, half vector, light and view, the latter two positive.
  float wet_lobe(float nh, float nl, float nv, float alpha) {
    float a2 = alpha * alpha;
    float bell = nh * nh * (a2 - 1.0f) + 1.0f;
    float masks = nl * sqrt(nv * nv * (1.0f - a2) + a2) + nv * sqrt(nl * nl * (1.0f - a2) + a2);
    return a2 / (3.14159265f * bell * bell) * 0.5f / masks;
  }

  // Reflectance distribution of the film [1/sr].
  float wet_film(float nh, float nl, float nv, float vh) {
    return wet_fresnel(vh) * (0.7f * wet_lobe(nh, nl, nv, 0.09f) + 0.3f * wet_lobe(nh, nl, nv, 0.3f));
  }

  // Share of even surroundings that the film reflects towards the view: a fit of the integral of wet_film.
  float wet_surroundings(float nv) {
    float left = 1.0f - nv;
    float square = left * left;
    return 0.0204f + 0.42f * square * square;
  }

  // Share of the base's light that passes the film in and out. The mean of the Fresnel factor over all
  // directions is 0.0204 + 0.9796 / 21.
  float wet_base(float nv) { return (1.0f - 0.0670f) * (1.0f - wet_fresnel(nv)); }

  // Light of the base from a direction, with subsurface scattering: Lambert's cosine wrapped around the
  // terminator by `wrap`, and scaled to reflect no more than it receives.
  float wet_wrapped(float nl, float wrap) {
    float lit = (nl + wrap) / ((1.0f + wrap) * (1.0f + wrap));
    return lit > 0.0f ? lit : 0.0f;
  }
)
// clang-format on

// Light of a wet surface from all lights of kLighting, as lit_surface of a dry one.
constexpr const char* kWetLighting = R"(
float film_light(vec3 n, vec3 view, float nv, vec3 light) {
  vec3 h = normalize(light + view);
  float nl = max(dot(n, light), 0.0);
  return 3.14159265 * nl * wet_film(max(dot(n, h), 0.0), nl, nv, max(dot(view, h), 0.0));
}

vec3 wet_surface(vec4 color, vec3 n, vec3 view, float open) {
  vec3 albedo = color.rgb * color.rgb;
  float nv = max(dot(n, view), 0.1), towards = dot(n, key);
  // the base, whose terminator is soft, and softest in red
  float share = mix(1.0, 0.12 + 0.88 * open, smoothstep(0.0, 0.3, towards));
  vec3 wrapped = vec3(wet_wrapped(towards, 0.32), wet_wrapped(towards, 0.20), wet_wrapped(towards, 0.15));
  vec3 lit = key_color * share * wrapped + fill_color * max(0.0, dot(n, fill));
  lit += mix(floor_color, sky_color, 0.5 + 0.5 * dot(n, up));
  // the film, which mirrors lights and surroundings
  vec3 mirrored = reflect(-view, n);
  vec3 shine = key_color * open * film_light(n, view, nv, key) + fill_color * film_light(n, view, nv, fill);
  shine += rim_color * film_light(n, view, nv, rim);
  shine += wet_surroundings(nv) * mix(floor_color, sky_color, 0.5 + 0.5 * dot(mirrored, up));
  return albedo * lit * wet_base(nv) + shine;
}
)";

}  // namespace turgor

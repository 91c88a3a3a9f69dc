#include "turgor/view/mesh_programs.hpp"

#include <string>

#include "turgor/view/mesh_shaders.hpp"
#include "turgor/view/quick_shaders.hpp"
#include "turgor/view/wet_reflection.hpp"

namespace turgor {

namespace {

// The source with a macro defined after its first line, which has the version.
std::string with_cut(std::string source) { return source.insert(source.find('\n') + 1, "#define CUT\n"); }

}  // namespace

Result<MeshPrograms> link_mesh_programs() {
  MeshPrograms programs;
  const std::string lighting = kLighting, wet = WetReflection::kSource;
  const std::string dry_light = lighting + kDryLight + kKeyShare, wet_light = lighting + wet + kWetLighting;
  struct ScreenSource {
    GLuint* program;
    std::string fragment;
  };
  const ScreenSource screens[] = {
      {&programs.resolve, lighting + kResolveMain},
      {&programs.smooth, dry_light + kSmoothMain},
      {&programs.edge, dry_light + kEdgeMain},
      {&programs.wet_smooth, wet_light + kWetLight + kKeyShare + kSmoothMain},
      {&programs.wet_edge, wet_light + kEitherLight + kKeyShare + kEdgeMain},
      {&programs.inner, lighting + kInnerMain},
      {&programs.occlusion, kOcclusionFragmentShader},
      {&programs.picture, kPictureFragmentShader},
  };
  for (const ScreenSource& one : screens) {
    const Result<GLuint> linked = link_program(kScreenVertexShader, one.fragment.c_str());
    if (!linked) return linked.error();
    *one.program = *linked;
  }
  struct SurfaceSource {
    SurfaceProgram* program;
    std::string vertex;
    const char* fragment;
  };
  const SurfaceSource surfaces[] = {
      {&programs.shadow, kShadowVertexShader, kShadowFragmentShader},
      {&programs.surface, kSurfaceVertexShader, kSurfaceFragmentShader},
      {&programs.quick, kQuickVertexShader, kQuickFragmentShader},
  };
  for (const SurfaceSource& one : surfaces) {
    const Result<GLuint> whole = link_program(one.vertex.c_str(), one.fragment),
                         cut = link_program(with_cut(one.vertex).c_str(), with_cut(one.fragment).c_str());
    if (!whole || !cut) return whole ? cut.error() : whole.error();
    *one.program = {*whole, *cut};
  }
  return programs;
}

}  // namespace turgor

// Time of a picture of 100 000 triangles at 960 × 720, in the quick quality of a moving window and in full
// quality, of a dry and a wet surface, and of the same surface subdivided into 400 000. A closed surface
// shows no back faces. Without a GPU: LIBGL_ALWAYS_SOFTWARE=1.
#include "turgor/view/mesh_drawing.hpp"

#include <numbers>

#include <benchmark/benchmark.h>

#include "turgor/geometry/loop_subdivision.hpp"
#include "turgor/view/gl_context.hpp"

namespace turgor {
namespace {

/// A ball of 4 · rings² triangles, with waves.
TriMesh wavy_ball(int rings) {
  TriMesh mesh;
  const int columns = 2 * rings;
  for (int j = 0; j <= rings; j++)
    for (int i = 0; i < columns; i++) {
      const float polar = std::numbers::pi_v<float> * float(j) / float(rings),
                  turn = std::numbers::pi_v<float> * float(i) / float(rings);
      const float radius = 0.2f + 0.01f * std::sin(9 * turn) * std::sin(7 * polar);
      mesh.vertices.push_back(
          Vec3{std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)} * radius);
    }
  for (int j = 0; j < rings; j++)
    for (int i = 0; i < columns; i++) {
      const int a = j * columns + i, b = j * columns + (i + 1) % columns;
      mesh.triangles.push_back({a, a + columns, b});
      mesh.triangles.push_back({b, a + columns, b + columns});
    }
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

TriMesh subdivided(const TriMesh& coarse) {
  const SmoothSurface surface = loop_subdivision(coarse.triangles, 1);
  TriMesh mesh{.vertices = {}, .triangles = surface.triangles, .normals = {}, .scalars = {}};
  for (std::size_t v = 0; v < surface.size(); v++)
    mesh.vertices.push_back(interpolated(surface, v, std::span(coarse.vertices)));
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

void draw(benchmark::State& state, RenderQuality quality, bool wet, bool closed, bool in_fours = false) {
  const Result<CurrentGl> gl = hold_gl();
  const Result<MeshPrograms> programs = gl ? link_mesh_programs() : Result<MeshPrograms>(gl.error());
  if (!programs) return state.SkipWithError(programs.error().message.c_str());
  MeshDrawing drawing;
  drawing.programs = *programs;
  const TriMesh ball = in_fours ? subdivided(wavy_ball(158)) : wavy_ball(158);
  const Camera camera{.eye = {0, -1, 0}, .target = {}};
  for (auto _ : state) {
    const Result<GLuint> drawn =
        draw_into_texture(drawing, {{.mesh = &ball, .in_fours = in_fours, .closed = closed, .wet = wet}},
                          camera, 960, 720, quality);
    if (!drawn) return state.SkipWithError(drawn.error().message.c_str());
    glFinish();
  }
  state.counters["pictures/s"] =
      benchmark::Counter(double(state.iterations()), benchmark::Counter::kIsRate);  // wall clock
  state.SetLabel(reinterpret_cast<const char*>(glGetString(GL_RENDERER)));
  state.counters["triangles"] = double(ball.triangles.size());
}

BENCHMARK_CAPTURE(draw, quick, RenderQuality::kQuick, false, false)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK_CAPTURE(draw, quick_closed, RenderQuality::kQuick, false, true)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK_CAPTURE(draw, quick_subdivided, RenderQuality::kQuick, false, true, true)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK_CAPTURE(draw, full_subdivided, RenderQuality::kFull, false, true, true)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK_CAPTURE(draw, full, RenderQuality::kFull, false, false)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK_CAPTURE(draw, full_wet, RenderQuality::kFull, true, false)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();

}  // namespace
}  // namespace turgor

BENCHMARK_MAIN();

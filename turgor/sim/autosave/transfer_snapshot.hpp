// transfer() of snapshots and measures.
#pragma once

#include "turgor/sim/autosave/transfer_models.hpp"
#include "turgor/sim/report/measures.hpp"
#include "turgor/sim/smooth_snapshot.hpp"
#include "turgor/sim/snapshot.hpp"

namespace turgor {

template <class File>
void transfer(File& file, TriMesh& mesh) {
  auto& [vertices, triangles, normals, scalars] = mesh;
  transfer_all(file, vertices, triangles, normals, scalars);
}
template <class File, class T>
void transfer(File& file, Volume<T>& volume) {
  auto& [grid, samples] = volume;
  transfer_all(file, grid, samples);
}
template <class File>
void transfer(File& file, LayerLook& look) {
  auto& [name, color] = look;
  transfer_all(file, name, color);
}
template <class File>
void transfer(File& file, WallLayers& walls) {
  auto& [corner, weight, layer, triangles, looks] = walls;
  transfer_all(file, corner, weight, layer, triangles, looks);
}
/// Without the cache, which show() fills again, and without the smooth surface, which reading makes again.
template <class File>
void transfer(File& file, BodySnapshot& body) {
  auto& [id, name, look, rest, displacement, x, normals, pressure, stretch, triangles, mesh_vertex, patch,
         inside, inside_names, smooth, sections, wall_begin, cap_count, wall_layers, box, typical_force,
         seconds, cache] = body;
  transfer_all(file, id, name, look, rest, displacement, x, normals, pressure, stretch, triangles,
               mesh_vertex, patch, inside, inside_names, smooth.coarse, sections, wall_begin, cap_count,
               wall_layers, box, typical_force, seconds);
  if constexpr (File::kReads) cache.reset(), show_smooth(body);
}
template <class File>
void transfer(File& file, ToolSnapshot& tool) {
  auto& [name, body, pose, force, opening, size, has_jaws, is_needle, mesh] = tool;
  transfer_all(file, name, body, pose, force, opening, size, has_jaws, is_needle, mesh);
}
template <class File>
void transfer(File& file, OrganForce& force) {
  auto& [name, body, at, newtons] = force;
  transfer_all(file, name, body, at, newtons);
}
template <class File>
void transfer(File& file, WorldSnapshot& snapshot) {
  auto& [time, frame, bodies, tools, obstacles, threads, organ_forces, cutaway] = snapshot;  // the scene's
  transfer_all(file, time, frame, bodies, tools, obstacles, threads, organ_forces);
}
template <class File>
void transfer(File& file, Pressed& pressed) {
  auto& [id, force, time, body, tools, surface_seconds] = pressed;
  transfer_all(file, id, force, time, body, tools, surface_seconds);
}
template <class File>
void transfer(File& file, CutMeasures& cut) {
  auto& [name, body, edges, region, excision, depth, width, tension, gape_error, marked, specimen, dog_ears,
         undermined, series, wound] = cut;
  transfer_all(file, name, body, edges, region, excision, depth, width, tension, gape_error, marked, specimen,
               dog_ears, undermined, series, wound);
}
template <class File>
void transfer(File& file, SutureMeasures& suture) {
  auto& [name, wound, thread, pattern, skin_force, series, stitches] = suture;
  transfer_all(file, name, wound, thread, pattern, skin_force, series, stitches);
}
template <class File>
void transfer(File& file, Measures& measures) {
  auto& [cuts, sutures, wound_surfaces, pressed, solver, frame_seconds] = measures;
  transfer_all(file, cuts, sutures, wound_surfaces, pressed, solver, frame_seconds);
}

}  // namespace turgor

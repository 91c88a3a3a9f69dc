// transfer() of the unfinished outputs of a run (sim/autosave/transfer.hpp).
#pragma once

#include <string>
#include <vector>

#include "turgor/pictures/outputs.hpp"
#include "turgor/sim/autosave/autosave_folder.hpp"
#include "turgor/sim/autosave/transfer_snapshot.hpp"
#include "turgor/sim/report/plausibility.hpp"
#include "turgor/sim/run.hpp"

namespace turgor {

/// Identity of a state, compared before a world is loaded for it.
struct AutosaveHeader {
  std::string program, scene;
  std::vector<std::string> overrides;
  double time = 0;  // simulated [s]
  std::uint64_t loaded_hash = 0;
};
template <class File>
void transfer(File& file, AutosaveHeader& header) {
  auto& [program, scene, overrides, time, loaded_hash] = header;
  transfer_all(file, program, scene, overrides, time, loaded_hash);
}

template <class File>
void transfer(File& file, SavedFile& saved) {
  auto& [name, size, grows] = saved;
  transfer_all(file, name, size, grows);
}
template <class File>
void transfer(File& file, ReportPicture& picture) {
  auto& [name, caption, large] = picture;
  transfer_all(file, name, caption, large);
}
template <class File>
void transfer(File& file, DeformedCtReport& deformed) {
  auto& [body, name, size, seconds, mass_error, folds] = deformed;
  transfer_all(file, body, name, size, seconds, mass_error, folds);
}
template <class File>
void transfer(File& file, RunFacts& facts) {
  auto& [load, simulation, output, total, drawing, writing, resumed_after, pictures, more_pictures, files,
         deformed, warnings] = facts;
  transfer_all(file, load, simulation, output, total, drawing, writing, resumed_after, pictures,
               more_pictures, files, deformed, warnings);
}
template <class File>
void transfer(File& file, PvdEntry& entry) {
  auto& [time, name, body] = entry;
  transfer_all(file, time, name, body);
}
/// Without values.
template <class File>
void transfer(File& file, VertexField& field) {
  auto& [name, components, values, is_length, is_direction] = field;
  transfer_all(file, name, components, is_length, is_direction);
}
template <class File>
void transfer(File& file, VtkHdfProgress& progress) {
  auto& [fields, corners, steps, blocks, points, block_points, cells, block_cells, ids] = progress;
  transfer_all(file, fields, corners, steps, blocks, points, block_points, cells, block_cells, ids);
}
template <class File>
void transfer(File& file, ShapeSample& sample) {
  auto& [points, normals, triangulation] = sample;
  transfer_all(file, points, normals, triangulation);
}
template <class File>
void transfer(File& file, AnimatedSurface& surface) {
  auto& [name, look, triangulations, colors, samples] = surface;
  transfer_all(file, name, look, triangulations, colors, samples);
}
template <class File>
void transfer(File& file, SurfaceAnimation& animation) {
  auto& [frame_rate, times, surfaces] = animation;
  transfer_all(file, frame_rate, times, surfaces);
}
template <class File>
void transfer(File& file, MovingSurface& surface) {
  auto& [key, vertex, rest, triangles, wall_begin, colors] = surface;
  transfer_all(file, key, vertex, rest, triangles, wall_begin, colors);
}
template <class File>
void transfer(File& file, MovingThing& thing) {
  auto& [kind, name, look, typical_force, surfaces] = thing;
  transfer_all(file, kind, name, look, typical_force, surfaces);
}
template <class File>
void transfer(File& file, MotionFrame& frame) {
  auto& [time, surface, moved, forces] = frame;
  transfer_all(file, time, surface, moved, forces);
}
template <class File>
void transfer(File& file, Motion& motion) {
  auto& [things, frames, numbers] = motion;
  transfer_all(file, things, frames, numbers);
}
template <class File>
void transfer(File& file, ClothStretch& stretch) {
  auto& [body, most, time] = stretch;
  transfer_all(file, body, most, time);
}
/// The result of simulate() so far: a run that goes on was not stopped.
template <class File>
void transfer(File& file, Simulated& simulated) {
  auto& [measures, snapshot, show_seconds, stopped, finite] = simulated;
  transfer_all(file, measures, snapshot, show_seconds, stopped, finite);
}

}  // namespace turgor

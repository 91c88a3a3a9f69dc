// transfer() of the states of all models and of their contacts. Every member of a state is stored, also
// workspaces whose content a later step may read. Exceptions are named. The lists follow the order of the
// members.
#pragma once

#include <memory>

#include "turgor/contact/lattice_needle.hpp"
#include "turgor/contact/lattice_touch.hpp"
#include "turgor/contact/rhombus_touch.hpp"
#include "turgor/contact/sfem_touch.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/models/cloth/model/state.hpp"
#include "turgor/models/lattice/surface/surface.hpp"
#include "turgor/models/lattice/suture/closure.hpp"
#include "turgor/models/rhombus/rhombus.hpp"
#include "turgor/models/sfem/rotation.hpp"
#include "turgor/sim/autosave/transfer.hpp"

namespace turgor {

// Lattice ------------------------------------------------------------------------------------------

template <class File>
void transfer(File& file, lattice::VecField& field) {
  auto& [x, y, z] = field;
  transfer_all(file, x, y, z);
}
template <class File>
void transfer(File& file, lattice::CutElements& elements) {
  auto& [cells, skin, nodes, virtual_nodes, layer_begin, references, keys] = elements;
  transfer_all(file, cells, skin, nodes, virtual_nodes, layer_begin, references, keys);
}
template <class File>
void transfer(File& file, lattice::Sleep& sleep) {
  auto& [still, awake, moved, cuts, gravity, moved_by_coarse, coarse_still] = sleep;
  transfer_all(file, still, awake, moved, cuts, gravity, moved_by_coarse, coarse_still);
}
template <class File>
void transfer(File& file, lattice::ResidualWorkspace& workspace) {
  auto& [layers, virtual_nodes] = workspace;
  transfer_all(file, layers, virtual_nodes);
}
template <class File>
void transfer(File& file, lattice::Motion& motion) {
  auto& [time, u, u_before, v, fastest, virtual_u, virtual_before] = motion;
  transfer_all(file, time, u, u_before, v, fastest, virtual_u, virtual_before);
}
/// Without the fragments, which fragments_of computes again.
template <class File>
void transfer(File& file, lattice::Cuts& cuts) {
  auto& [cut, removed, row_cut, skin_cut, edges, samples, sample_count, removed_nodes, excised, blades,
         fragments] = cuts;
  transfer_all(file, cut, removed, row_cut, skin_cut, edges, samples, sample_count, removed_nodes, excised,
               blades);
  if constexpr (File::kReads) fragments.reset();  // they are those of other cuts
}
/// Without the coarse space, which the reader builds again (transfer_body).
template <class File>
void transfer(File& file, lattice::Workspace& workspace) {
  auto& [coarse, residual, cuts_before, steps_since_cut] = workspace;
  transfer_all(file, residual, cuts_before, steps_since_cut);
}
template <class File>
void transfer(File& file, lattice::SymmetricField& field) {
  auto& [xx, yy, zz, xy, xz, yz] = field;
  transfer_all(file, xx, yy, zz, xy, xz, yz);
}
template <class File>
void transfer(File& file, lattice::Viscosity& viscosity) {
  auto& [history, instant, instants, in_step] = viscosity;
  transfer_all(file, history, instant, instants, in_step);
}
template <class File>
void transfer(File& file, lattice::State& state) {
  auto& [motion, cuts, elements, sleep, workspace, viscosity] = state;
  transfer_all(file, motion, cuts, elements, sleep, workspace, viscosity);
}
/// A table of keys with their numbers 0, 1, 2, …
template <class File>
void transfer(File& file, KeyIndex& index) {
  std::vector<std::uint64_t> keys(index.size());
  for (const KeyEntry& entry : index.entries())
    if (entry.value >= 0) keys[std::size_t(entry.value)] = entry.key;
  transfer(file, keys);
  if constexpr (File::kReads) {
    index = {};
    for (const std::uint64_t key : keys) index.find_or_add(key);
  }
}
template <class File>
void transfer(File& file, lattice::Fragments& fragments) {
  auto& [fine, cells, cell_index, all, ghosts, label, cut, virtual_nodes, terms, tips, edge_index, version,
         stages] = fragments;
  transfer_all(file, fine, cells, cell_index, all, ghosts, label, cut, virtual_nodes, terms, tips, edge_index,
               version);
  if constexpr (File::kReads) stages = {};  // the next cut makes its fragments from the beginning
}
template <class File>
void transfer(File& file, std::shared_ptr<const lattice::Fragments>& shared) {
  bool has_value = shared != nullptr;
  transfer(file, has_value);
  if (!has_value) {
    shared = nullptr;
    return;
  }
  lattice::Fragments fragments;
  if constexpr (!File::kReads) fragments = *shared;
  transfer(file, fragments);
  if constexpr (File::kReads) shared = std::make_shared<const lattice::Fragments>(std::move(fragments));
}
template <class File>
void transfer(File& file, lattice::BodySurface& surface) {
  auto& [rest, embedding, slot, twin, lips, triangles, skin_triangles, cap_triangles, fragments, plan] =
      surface;
  transfer_all(file, rest, embedding, slot, twin, lips, triangles, skin_triangles, cap_triangles, fragments);
  if constexpr (File::kReads) plan.reset();  // derived; made again with its body
}
template <class File>
void transfer(File& file, lattice::BladePath& path) {
  auto& [points, inward, depth, width, depths, edges, fine_edges, lines, is_excision] = path;
  transfer_all(file, points, inward, depth, width, depths, edges, fine_edges, lines, is_excision);
}
template <class File>
void transfer(File& file, lattice::Wound& wound) {
  auto& [length, gape_max, gape_mean, opening_area, edge_displacement, profile] = wound;
  transfer_all(file, length, gape_max, gape_mean, opening_area, edge_displacement, profile);
}
template <class File>
void transfer(File& file, lattice::Stitch& stitch) {
  auto& [rest, side, is_open, keeps_bites, along, middle, across, gap, shortest, at, lips, phase, length,
         before, tension, multiplier, ended] = stitch;
  transfer_all(file, rest, side, is_open, keeps_bites, along, middle, across, gap, shortest, at, lips, phase,
               length, before, tension, multiplier, ended);
}
template <class File>
void transfer(File& file, lattice::WoundClosure& closure) {
  auto& [thread, pull_out, stitches, walls, is_running, version, settled] = closure;
  transfer_all(file, thread, pull_out, stitches, walls, is_running, version, settled);
}
template <class File>
void transfer(File& file, lattice::ContactPoints& points) {
  auto& [at, leader, terms, concentration] = points;
  transfer_all(file, at, leader, terms, concentration);
}
template <class File>
void transfer(File& file, contact::LatticeTouch& touch) {
  auto& [samples, in_cells, points, is_far, virtual_slots, version, contacts, poses, nodes, contact_points] =
      touch;
  transfer_all(file, samples, in_cells, points, is_far, virtual_slots, version, contacts, poses, nodes,
               contact_points);
}

template <class File>
void transfer(File& file, contact::LatticeNeedleTrack& track) {
  auto& [points, length, entry_at, entry, is_at_exit, gap, is_through, order] = track;
  transfer_all(file, points, length, entry_at, entry, is_at_exit, gap, is_through, order);
}
template <class File>
void transfer(File& file, contact::LatticeNeedle& needle) {
  auto& [phase, seen, before, pose, track, inserted, force, torque, tip_force, entry_force, punctures, made,
         given, work, reading, tracks, cuts, settled] = needle;
  transfer_all(file, phase, seen, before, pose, track, inserted, force, torque, tip_force, entry_force,
               punctures, made, given, work, reading, tracks, cuts, settled);
}

// Cloth --------------------------------------------------------------------------------------------

template <class File>
void transfer(File& file, cloth::Vectors& vectors) {
  auto& [x, y, z] = vectors;
  transfer_all(file, x, y, z);
}
template <class File>
void transfer(File& file, cloth::SpatialHash& hash) {
  auto& [cell, mask, begin, bucket, index, x, y, z] = hash;
  transfer_all(file, cell, mask, begin, bucket, index, x, y, z);
}
template <class File>
void transfer(File& file, cloth::Contacts& contacts) {
  // pairs of a search are of use within a step only
  auto& [list, begin, item, touched, candidates, midpoint_hash, midpoints, longest_half, near_pairs,
         near_reach] = contacts;
  transfer_all(file, list, begin, item, touched, candidates, midpoint_hash, midpoints, longest_half);
}
template <class File>
void transfer(File& file, cloth::ImplicitContacts& implicit) {
  // free obstacles are of use within a step only
  auto& [contacts, terms, inverse, free] = implicit;
  transfer_all(file, contacts, terms, inverse);
}
template <class File>
void transfer(File& file, cloth::CcdWorkspace& ccd) {
  auto& [boxes, level_begin, chunk_pairs, pairs, recent, steps_until_check, in_zone, zone, is_changed] = ccd;
  transfer_all(file, boxes, level_begin, chunk_pairs, pairs, recent, steps_until_check, in_zone, zone,
               is_changed);
}
/// Without the two-level system, which every step builds again.
template <class File>
void transfer(File& file, cloth::System& system) {
  auto& [along, across, force, inverse, change, previous, search, image, residual_vector, air, stiffness,
         mass, drag, two_level, iterations, residual] = system;
  transfer_all(file, along, across, force, inverse[0], inverse[1], change, previous, search, image,
               residual_vector, air[0], air[1], stiffness, mass, drag, iterations, residual);
}
template <class File>
void transfer(File& file, cloth::Bdf2History& history) {
  auto& [dt, x, v] = history;
  transfer_all(file, dt, x, v);
}
template <class File>
void transfer(File& file, cloth::State& state) {
  auto& [time, impulse_time, history, x, v, free_mass, holds, system, contacts, implicit, hash, ccd, speed] =
      state;
  transfer_all(file, time, impulse_time, history, x, v, free_mass, holds, system, contacts, implicit, hash,
               ccd, speed);
}

// sfem ---------------------------------------------------------------------------------------------

template <class File>
void transfer(File& file, sfem::PatchLevel& level) {
  auto& [cluster, first, points, share, motion, compliance] = level;
  transfer_all(file, cluster, first, points, share, motion, compliance);
}
template <class File, class T>
void transfer(File& file, sfem::CondensedSystem<T>& system) {
  auto& [factor, coupling, green, change] = system;
  transfer_all(file, factor, coupling, green, change);
}
template <class File>
void transfer(File& file, sfem::LinearizedSystem& system) {
  auto& [motion, response, stiffness] = system;
  transfer_all(file, motion, response, stiffness);
}
template <class File>
void transfer(File& file, sfem::Patch& patch) {
  auto& [elements, coarse, points, triangles, compliance, levels, local_nodes, surface_nodes, system, shift] =
      patch;
  transfer_all(file, elements, coarse, points, triangles, compliance, levels, local_nodes, surface_nodes,
               system, shift);
}
template <class File>
void transfer(File& file, sfem::RoundHistory& history) {
  auto& [moves, changes, u, step] = history;
  transfer_all(file, moves, changes, u, step);
}
template <class File>
void transfer(File& file, sfem::RotationState& state) {
  auto& [displacement, free, rotation, u, forces, history, idle] = state;
  transfer_all(file, displacement, free, rotation, u, forces, history, idle);
}
template <class File>
void transfer(File& file, contact::PatchSurface& surface) {
  auto& [normal, area, softness, border, largest_softness] = surface;
  transfer_all(file, normal, area, softness, border, largest_softness);
}
template <class File>
void transfer(File& file, contact::PairHistory& pair) {
  auto& [v, phi, far] = pair;
  transfer_all(file, v, phi, far);
}
template <class File>
void transfer(File& file, contact::ViscousHistory& history) {
  auto& [pairs, count, far_factor] = history;
  for (contact::PairHistory& pair : pairs) transfer(file, pair);
  transfer_all(file, count, far_factor);
}
template <class File>
void transfer(File& file, contact::FrictionalContactProblem& problem) {
  auto& [count, held, stride, compliance, separation, force, normal, friction, state, laws, saved, matrix,
         columns, rhs, newton_sites] = problem;
  transfer_all(file, count, held, stride, compliance, separation, force, normal, friction, state, laws, saved,
               matrix, columns, rhs, newton_sites);
}
template <class File>
void transfer(File& file, contact::PatchMatch& match) {
  auto& [from_order, to_order, new_point, old_point, offset, history, forces] = match;
  transfer_all(file, from_order, to_order, new_point, old_point, offset, history, forces);
}
template <class File>
void transfer(File& file, contact::TouchState& state) {
  auto& [params, surface, x, u, outward, force, offset, history, sites, held, tools, jumps, poses, forces,
         solution, problem, new_sites, match] = state;
  transfer_all(file, params, surface, x, u, outward, force, offset, history, sites, held, tools, jumps, poses,
               forces, solution, problem, new_sites, match);
}
template <class File>
void transfer(File& file, contact::FreeMotionInterpolation& free) {
  auto& [moves, from, to, ticks, done] = free;
  transfer_all(file, moves, from, to, ticks, done);
}

template <class File>
void transfer(File& file, contact::NeedleTrack& track) {
  auto& [points, force, before, compliance, length, entry, is_at_exit, is_through, order, offset] = track;
  transfer_all(file, points, force, before, compliance, length, entry, is_at_exit, is_through, order, offset);
}
template <class File>
void transfer(File& file, contact::NeedleState& state) {
  auto& [phase, seen, pose, step, track, inserted, force, torque, tip_force, entry_force, punctures, made,
         sweeps, beyond, work, reading, beam, tracks, motion, free, carried, carried_points, x, force_on,
         carried_by, row, on_vertex] = state;
  transfer_all(file, phase, seen, pose, step, track, inserted, force, torque, tip_force, entry_force,
               punctures, made, sweeps, beyond, work, reading, beam, tracks, motion, free, carried,
               carried_points, x, force_on, carried_by, row, on_vertex);
}
/// Without the Green's functions, which loading solves again.
template <class File>
void transfer(File& file, contact::NeedleTouch& touch) {
  auto& [inner, needles] = touch;
  transfer(file, needles);
}

// Rhombus ------------------------------------------------------------------------------------------

template <class File>
void transfer(File& file, rhombus::GeodesicField& field) {
  auto& [distance, reached, source, radius, front] = field;
  transfer_all(file, distance, reached, source, radius, front);
}
template <class File>
void transfer(File& file, rhombus::State& state) {
  auto& [touches, displacement, moved, distances, carried, ring, listed] = state;
  transfer_all(file, touches, displacement, moved, distances, carried, ring, listed);
}
/// Without the height map, which the scene gives.
template <class File>
void transfer(File& file, contact::RhombusTouch& touch) {
  auto& [tips, touches, poses, inputs, forces, ticks, tissue, map, textures] = touch;
  transfer_all(file, tips, touches, poses, inputs, forces, ticks, tissue, textures);
}
template <class File>
void transfer(File& file, contact::RhombusTouchSnapshot& snapshot) {
  auto& [touches, poses, inputs, forces, ticks, textures] = snapshot;
  transfer_all(file, touches, poses, inputs, forces, ticks, textures);
}

}  // namespace turgor

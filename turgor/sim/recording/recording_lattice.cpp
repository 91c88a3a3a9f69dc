#include "turgor/sim/recording/recording_lattice.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include <fmt/format.h>

#include "turgor/models/lattice/cutting/fine_lattice.hpp"
#include "turgor/models/lattice/model/fields.hpp"
#include "turgor/sim/recording/recording_fields.hpp"
#include "turgor/sim/recording/recording_touch.hpp"

namespace turgor {

namespace {

std::vector<int> node_slots(const lattice::Model& model) {
  std::vector<int> slots;
  for (int s = 0; s < slot_count(model.anatomy.lattice); s++)
    if (has_node(model, s)) slots.push_back(s);
  return slots;
}

/// Sample lines that blades crossed. They decide which virtual nodes have displacements of their own.
void write_cut_samples(Writing& writing, const std::vector<lattice::CutFractionSamples>& samples) {
  if (samples.empty()) return;
  std::vector<std::int32_t> cells;
  std::vector<std::uint64_t> lines;
  for (const lattice::CutFractionSamples& one : samples) {
    cells.insert(cells.end(), {one.slot, one.incision});
    lines.insert(lines.end(), one.lines.begin(), one.lines.end());
  }
  writing.array("cut_sample_cells", cells, 2).array("cut_sample_lines", lines, 3);
}

/// True if the lattice has such an edge.
bool is_edge(const World& world, const lattice::Model& model, const lattice::CutEdge& edge) {
  if (edge.slot < 0 || edge.slot >= slot_count(model.anatomy.lattice) || edge.family >= kFamilyCount)
    return false;
  if (edge.incision >= world.cuts.size() || !(edge.fraction >= 0 && edge.fraction <= 1)) return false;
  const Int3 cell = slot_node(model.anatomy.lattice, edge.slot);
  if (!contains(model.anatomy.lattice, cell) || node_slot(model.anatomy.lattice, cell) != edge.slot ||
      edge.sub_index < 0 || edge.sub_index >= 8 * 8 * 8 || !std::isfinite(edge.along))
    return false;
  const lattice::FineLattice fine = lattice::fine_lattice(model);
  const Int3 node = fine_node(fine, edge);
  return contains(fine, node) && cell_of(fine, node) == cell && contains(fine, node + kFamilies[edge.family]);
}

/// Virtual nodes of cut solid tissue.
void read_virtual_nodes(const SnapshotIn& in, const LatticeBody& body, std::size_t most, Reading& reading,
                        lattice::State& state) {
  const std::string path = fmt::format("{}/bodies/{}/virtual_nodes", in.group, body.name);
  if (!in.file.has(stored_path(in.file, path))) return;
  const auto values = reading.array<float>("virtual_nodes", reading.count("virtual_nodes", 3 * most));
  for (std::size_t n = 0; n + 2 < values.size(); n += 3) {
    const lattice::VirtualNodeDisplacement c{values[n], values[n + 1], values[n + 2]};
    if (!std::isfinite(c.x + c.y + c.z)) reading.fail("virtual_nodes", "a value is not a number");
    state.motion.virtual_u.push_back(c);
  }
}

/// Sample lines that blades crossed; recordings of version 0.2 lack them.
void read_cut_samples(const SnapshotIn& in, const LatticeBody& body, Reading& reading, lattice::Cuts& cuts) {
  const std::string path = fmt::format("{}/bodies/{}/cut_sample_lines", in.group, body.name);
  if (!in.file.has(path)) return;
  const int slots = slot_count(body.model.anatomy.lattice);
  const std::size_t count =
      reading.count("cut_sample_lines",
                    3 * std::size_t(slots) * std::max<std::size_t>(1, in.world.cuts.size())) /
      3;
  const auto cells = reading.array<std::int32_t>("cut_sample_cells", 2 * count);
  const auto lines = reading.array<std::uint64_t>("cut_sample_lines", 3 * count);
  if (cells.size() < 2 * count || lines.size() < 3 * count) return;
  for (std::size_t n = 0; n < count; n++) {
    const int slot = cells[2 * n], incision = cells[2 * n + 1];
    if (slot < 0 || slot >= slots || incision < 0 || std::size_t(incision) >= in.world.cuts.size())
      return reading.fail("cut_sample_cells", "a row names no cell and incision");
    if (n > 0 && std::pair(cells[2 * n - 2], cells[2 * n - 1]) >= std::pair(slot, incision))
      return reading.fail("cut_sample_cells", "rows do not ascend by cell and incision");
    cuts.samples.push_back(
        {slot, std::uint8_t(incision), {lines[3 * n], lines[3 * n + 1], lines[3 * n + 2]}});
    for (const std::uint64_t of_axis : cuts.samples.back().lines) cuts.sample_count += std::popcount(of_axis);
  }
}

/// Slots of the nodes in a recording. Those made before partial cells existed have no rim nodes.
std::vector<int> recorded_slots(const SnapshotIn& in, const LatticeBody& body) {
  std::vector<int> slots = node_slots(body.model);
  const std::string path = stored_path(in.file, fmt::format("/bodies/{}/rest_points", body.name));
  const Result<std::size_t> found = in.file.count(path, 3 * slots.size());
  if (found && *found < 3 * slots.size())
    std::erase_if(slots, [&](int s) { return !lattice::is_body(body.model.anatomy.tissue[std::size_t(s)]); });
  return slots;
}

/// Excised fragments, which follow from the cuts.
Status restore_excised(const SnapshotIn& in, const LatticeBody& body, lattice::Cuts& cuts) {
  for (std::size_t c = 0; c < in.world.cuts.size(); c++) {
    const Cut& cut = in.world.cuts[c];
    if (&in.world.lattice_bodies[std::size_t(cut.body)] != &body) continue;
    if (!cut.blade.excision || !cut.path || cut.done < 1) continue;
    const Result<lattice::FreePiece> piece = lattice::find_piece(body.model, cuts, int(c));
    if (!piece)
      return Error{
          fmt::format("{}: {}: cut {}: {}", in.path, in.group, cut.blade.name, piece.error().message)};
    lattice::mark_excised(*piece, cuts);
  }
  return Done{};
}

}  // namespace

Status write_body(Hdf5File& file, const LatticeBody& body) {
  const lattice::Model& model = body.model;
  const Grid& grid = model.anatomy.grid;
  // rest positions of the nodes
  std::vector<float> rest;
  for (const int slot : node_slots(model)) {
    const Int3 node = slot_node(model.anatomy.lattice, slot);
    const Vec3 p(point_at(grid, {double(node.x), double(node.y), double(node.z)}));
    rest.insert(rest.end(), {p.x, p.y, p.z});
  }
  // write CT hash, kind of cells, lattice and rest positions
  return Writing(file, fmt::format("/bodies/{}/", body.name))
      .array<std::uint64_t>("ct_hash", {body.ct_hash})
      .array<std::int32_t>("partial_cells", {std::int32_t(model.params.tissue.partial_cells)})
      .array<std::int32_t>("lattice_size", {grid.size.x, grid.size.y, grid.size.z})
      .array("lattice_origin", flat<double>({grid.origin}), 1, "m")
      .array("lattice_spacing", flat<double>({grid.spacing}), 1, "m")
      .array("lattice_axes", flat<double>({grid.axes.column[0], grid.axes.column[1], grid.axes.column[2]}), 3)
      .array<std::uint64_t>("skin_triangles", {model.anatomy.skin.triangles.size()})
      .array("rest_points", rest, 3, "m")
      .status();
}

Status write_state(const SnapshotOut& out, const LatticeBody& body, BodyId id) {
  Writing writing(out.file, fmt::format("{}/bodies/{}/", out.group, body.name));
  write_fields(writing, *body.state, {Axis::kSlot, node_slots(body.model)});
  write_cut_samples(writing, body.state->cuts.samples);
  std::vector<float> virtual_nodes;
  for (const lattice::VirtualNodeDisplacement& c : body.state->motion.virtual_u)
    virtual_nodes.insert(virtual_nodes.end(), {c.x, c.y, c.z});
  if (!virtual_nodes.empty()) writing.array("virtual_nodes", virtual_nodes, 3, "m");
  return writing.status() ? write_tools(out, body, id) : writing.status();
}

Status read_state(const SnapshotIn& in, LatticeBody& body, BodyId id) {
  // fields and virtual nodes
  const std::vector<int> slots = recorded_slots(in, body);
  lattice::State state = lattice::make_state(body.model);
  Reading reading(in.file, fmt::format("{}/bodies/{}/", in.group, body.name));
  const Int3 subdivisions = lattice::fine_lattice(body.model).subdivisions;
  const std::size_t most =
      std::size_t(kFamilyCount * subdivisions.x * subdivisions.y * subdivisions.z) * slots.size();
  read_fields(reading, state, {Axis::kSlot, slots}, most);
  read_virtual_nodes(in, body, most, reading, state);
  read_cut_samples(in, body, reading, state.cuts);
  if (!reading.status()) return reading.status();

  // derived values
  state.motion.u_before = state.motion.u;
  for (const lattice::CutEdge& edge : state.cuts.edges)
    if (!is_edge(in.world, body.model, edge))
      return Error{fmt::format("{}: {}: a cut edge is not in the body", in.path, in.group)};
  state.cuts.removed_nodes = 0;
  for (const int slot : slots)
    if (state.cuts.removed[std::size_t(slot)] &&
        lattice::is_body(body.model.anatomy.tissue[std::size_t(slot)]))
      state.cuts.removed_nodes++;
  state.motion.time = time_of(in.world);
  if (const Status excised = restore_excised(in, body, state.cuts); !excised) return excised;
  body.state.change() = std::move(state);

  // tools and snapshot
  BodySnapshot none;
  if (!body.tool_indices.empty())
    if (const Status tools = read_tools(in, body, none); !tools) return tools;
  show(in.exec, body, body_snapshot(in.snapshot, id));
  return Done{};
}

}  // namespace turgor

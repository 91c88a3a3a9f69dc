#include "turgor/sim/recording/recording.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/models/lattice/cutting/fine_lattice.hpp"
#include "turgor/models/lattice/model/fields.hpp"
#include "turgor/sim/recording/recording_cloth.hpp"
#include "turgor/sim/recording/recording_fields.hpp"
#include "turgor/sim/recording/recording_suture.hpp"
#include "turgor/sim/recording/recording_touch.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

constexpr const char *kRecordingFormat = "turgor recording 7",
                     *kOldFormat = "turgor recording 6";  // the same with the names of renamed_datasets.hpp
constexpr std::size_t kMostSnapshots = 1000000, kMostPathPoints = 1 << 24;
constexpr double kUnitError = 1e-6;  // of the length of a unit vector

std::vector<int> node_slots(const lattice::Model& model) {
  std::vector<int> slots;
  for (int s = 0; s < slot_count(model.anatomy.lattice); s++)
    if (has_node(model, s)) slots.push_back(s);
  return slots;
}

std::string joined(const std::vector<std::string>& lines) {
  return fmt::format("{}", fmt::join(lines, "\n"));
}

std::vector<std::string> split_lines(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

std::vector<double> flat(const std::vector<Vec3d>& points) {
  std::vector<double> values;
  for (const Vec3d p : points) values.insert(values.end(), {p.x, p.y, p.z});
  return values;
}

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
  // write CT hash, lattice and rest positions
  return Writing(file, fmt::format("/bodies/{}/", body.name))
      .array<std::uint64_t>("ct_hash", {body.ct_hash})
      .array<std::int32_t>("lattice_size", {grid.size.x, grid.size.y, grid.size.z})
      .array("lattice_origin", flat({grid.origin}), 1, "m")
      .array("lattice_spacing", flat({grid.spacing}), 1, "m")
      .array("lattice_axes", flat({grid.axes.column[0], grid.axes.column[1], grid.axes.column[2]}), 3)
      .array<std::uint64_t>("skin_triangles", {model.anatomy.skin.triangles.size()})
      .array("rest_points", rest, 3, "m")
      .status();
}

Status write_state(const SnapshotOut& out, const LatticeBody& body, BodyId id) {
  Writing writing(out.file, fmt::format("{}/bodies/{}/", out.group, body.name));
  write_fields(writing, *body.state, {Axis::kSlot, node_slots(body.model)});
  std::vector<float> virtual_nodes;
  for (const lattice::VirtualNodeDisplacement& c : body.state->motion.virtual_u)
    virtual_nodes.insert(virtual_nodes.end(), {c.x, c.y, c.z});
  if (!virtual_nodes.empty()) writing.array("virtual_nodes", virtual_nodes, 3, "m");
  return writing.status() ? write_tools(out, body, id) : writing.status();
}

Status write_cut(Hdf5File& file, const std::string& group, const Cut& cut) {
  const lattice::BladePath path = cut.path.value_or(lattice::BladePath{});
  TURGOR_CHECK(path.inward.size() == path.points.size(), "every point of a path has a direction");
  return Writing(file, fmt::format("{}/cuts/{}/", group, cut.blade.name))
      .array("path", flat(path.points), 3, "m")
      .array("into", flat(path.inward), 3)
      .array<double>("progress", {path.depth, cut.done, double(cut.edges)}, 1, "m, 1, 1")
      .status();
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
  const auto flat = reading.array<float>("virtual_nodes", reading.count("virtual_nodes", 3 * most));
  for (std::size_t n = 0; n + 2 < flat.size(); n += 3) {
    const lattice::VirtualNodeDisplacement c{flat[n], flat[n + 1], flat[n + 2]};
    if (!std::isfinite(c.x + c.y + c.z)) reading.fail("virtual_nodes", "a value is not a number");
    state.motion.virtual_u.push_back(c);
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

std::string snapshot_group(int snapshot) { return fmt::format("/snapshots/{:05}", snapshot); }

}  // namespace

Result<RecordingWriter> RecordingWriter::create(const fs::path& path, const Scene& scene,
                                                const World& world) {
  Result<Hdf5File> file = Hdf5File::create(path);
  if (!file) return file.error();
  std::error_code ignored;
  const Status scene_written = Writing(*file, "/")
                                   .text("format", kRecordingFormat)
                                   .text("scene/file", fs::absolute(scene.file, ignored).string())
                                   .text("scene/text", scene.text)
                                   .text("scene/overrides", joined(scene.overrides))
                                   .text("scene/folder", fs::current_path(ignored).string())
                                   .status();
  if (!scene_written) return scene_written.error();
  for (const LatticeBody& body : world.lattice_bodies)
    if (const Status status = write_body(*file, body); !status) return status.error();
  return RecordingWriter(std::move(*file));
}

Result<RecordingWriter> RecordingWriter::resume(const fs::path& path, int snapshots) {
  Result<Hdf5File> file = Hdf5File::open_to_write(path);
  if (!file) return file.error();
  return RecordingWriter(std::move(*file), snapshots);
}

Status RecordingWriter::add_snapshot(const World& world, const WorldSnapshot& snapshot) {
  // time
  const std::string group = snapshot_group(snapshots_++);
  if (const Status status = Writing(file_, group + "/")
                                .array<double>("time", {time_of(world)}, 1, "s")
                                .array<std::int32_t>("frame", {world.frame})
                                .status();
      !status)
    return status;

  // bodies
  const SnapshotOut out{file_, group, snapshot};
  const Status bodies =
      try_each_body(world, [&](BodyId id, const auto& body) { return write_state(out, body, id); });
  if (!bodies) return bodies;

  // cuts
  for (const Cut& cut : world.cuts)
    if (const Status status = write_cut(file_, group, cut); !status) return status;
  for (const Suture& suture : world.sutures)
    if (const Status status = write_suture(file_, group, suture); !status) return status;
  return file_.flush();
}

Status RecordingWriter::finish(const World& world, const WorldSnapshot& snapshot,
                               const std::vector<Pressed>& pressed, const std::string& report) {
  if (const Status status = write_touch(file_, world, snapshot, pressed); !status) return status;
  const Status status =
      Writing(file_, "/").array<std::int32_t>("snapshot_count", {snapshots_}).text("report", report).status();
  return status ? file_.close() : status;
}

Result<Recording> Recording::open(const fs::path& path) {
  Result<Hdf5File> file = Hdf5File::open(path);
  if (!file) return file.error();

  // format
  const Result<std::string> format = file->read_text("/format");
  if (!format || !format->starts_with("turgor recording"))
    return Error{
        fmt::format("{}: expected a recording of turgor run, found another HDF5 file", path.string())};
  if (*format != kRecordingFormat && *format != kOldFormat)
    return Error{fmt::format("{}: expected \"{}\", found \"{}\", of another version of turgor", path.string(),
                             kRecordingFormat, *format)};

  // snapshots and report
  Recording recording(std::move(*file), path);
  const Result<std::vector<std::int32_t>> count = recording.file_.read<std::int32_t>("/snapshot_count", 1);
  const Result<std::string> report = recording.file_.read_text("/report");
  if (!count || !report || (*count)[0] < 1 || std::size_t((*count)[0]) > kMostSnapshots)
    return Error{fmt::format("{}: the recording is unfinished", path.string())};
  recording.snapshots_ = (*count)[0];
  recording.report_ = *report;
  return recording;
}

Result<Scene> Recording::scene(const std::vector<std::string>& more_overrides) const {
  // recorded scene
  std::string texts[4];
  const char* names[4] = {"/scene/file", "/scene/text", "/scene/overrides", "/scene/folder"};
  for (int i = 0; i < 4; i++) {
    Result<std::string> text = file_.read_text(names[i]);
    if (!text) return text.error();
    texts[i] = *text;
  }

  // only outputs and file locations may change
  for (const std::string& more : more_overrides) {
    const std::string key = more.substr(0, more.find('='));
    const auto ends_with = [&](const char* ending) { return key.ends_with(ending); };
    if (!key.starts_with("output.") && !ends_with(".ct") && !ends_with(".labels") &&
        !ends_with(".direction_field"))
      return Error{fmt::format(
          "--set {}: a replay may only change output.* and the locations of a body's files", key)};
  }
  std::vector<std::string> overrides = split_lines(texts[2]);
  overrides.insert(overrides.end(), more_overrides.begin(), more_overrides.end());
  // files of --set were relative to the folder of the recorded run
  Result<Scene> scene = parse_scene(texts[1], texts[0], overrides, texts[3]);
  if (!scene)
    return Error{fmt::format("{}: the recorded scene is invalid: {}", path_.string(), scene.error().message)};
  return scene;
}

Status Recording::check_world(const World& world) const {
  for (const LatticeBody& body : world.lattice_bodies) {
    // recorded properties
    Reading reading(file_, fmt::format("/bodies/{}/", body.name));
    const auto hash = reading.array<std::uint64_t>("ct_hash", 1);
    const auto triangles = reading.array<std::uint64_t>("skin_triangles", 1);
    const auto size = reading.array<std::int32_t>("lattice_size", 3);
    if (!reading.status()) return reading.status();

    // comparison
    if (hash[0] != body.ct_hash)
      return Error{
          fmt::format("{}: body.{} was recorded on another CT: expected content {}, found {}; name the right "
                      "one by --set body.{}.ct=FILE",
                      path_.string(), body.name, hash_text(hash[0]), hash_text(body.ct_hash), body.name)};
    if (triangles[0] != body.model.anatomy.skin.triangles.size() ||
        Int3{size[0], size[1], size[2]} != body.model.anatomy.grid.size)
      return Error{
          fmt::format("{}: body.{} differs from the recorded body: expected {} skin triangles, "
                      "found {}",
                      path_.string(), body.name, triangles[0], body.model.anatomy.skin.triangles.size())};
  }
  return Done{};
}

/// Path and progress of a cut. Drawing and measuring rely on the unit vectors.
Status Recording::restore_cut(const std::string& group, Cut& cut) const {
  // datasets
  Reading reading(file_, fmt::format("{}/cuts/{}/", group, cut.blade.name));
  const std::size_t values = reading.count("path", kMostPathPoints);
  const auto points = reading.array<double>("path", values);
  const auto into = reading.array<double>("into", values);
  const auto progress = reading.array<double>("progress", 3);
  if (values % 3 != 0) reading.fail("path", "expected three numbers a point");
  if (!reading.status()) return reading.status();

  // progress
  cut.path.reset();
  cut.done = progress[1], cut.edges = int(std::clamp(progress[2], 0.0, 2e9));
  if (values < 6) return Done{};  // the blade had not started

  // path
  lattice::BladePath path;
  for (std::size_t i = 0; i + 2 < values; i += 3) {
    path.points.push_back({points[i], points[i + 1], points[i + 2]});
    path.inward.push_back({into[i], into[i + 1], into[i + 2]});
    if (!std::isfinite(dot(path.points.back(), path.points.back())))
      reading.fail("path", fmt::format("row {}: expected finite numbers", i / 3 + 1));
    if (const double length = norm(path.inward.back()); !(std::abs(length - 1) <= kUnitError))
      reading.fail("into", fmt::format("row {}: expected a unit vector into the body, found one of length "
                                       "{:.6g}",
                                       i / 3 + 1, length));
  }
  if (!reading.status()) return reading.status();
  path.depth = progress[0], path.width = cut.blade.width;
  path.is_excision = cut.blade.excision.has_value();
  path.depths.assign(path.points.size(), path.depth);
  cut.path = std::move(path);
  return Done{};
}

Status Recording::restore(const Exec& exec, int index, World& world, WorldSnapshot& snapshot) const {
  // time
  TURGOR_ASSERT(index >= 0 && index < snapshots_, "the snapshot was recorded");
  const std::string group = snapshot_group(index);
  const Result<std::vector<std::int32_t>> frame = file_.read<std::int32_t>(group + "/frame", 1);
  if (!frame) return frame.error();
  world.frame = (*frame)[0];
  show_names(world, snapshot);

  // cuts and bodies
  for (Cut& cut : world.cuts)
    if (const Status status = restore_cut(group, cut); !status) return status;
  const SnapshotIn in{file_, path_.string(), group, exec, world, snapshot};
  const Status bodies = try_each_body(world, [&](BodyId id, auto& body) { return read_state(in, body, id); });
  if (!bodies) return bodies;

  // sutures
  for (Suture& suture : world.sutures)
    if (const Status status = read_suture_state(file_, group, world, suture); !status) return status;
  show_threads(world, snapshot);
  return Done{};
}

Status Recording::restore_touch(World& world, std::vector<Pressed>& pressed) const {
  return read_touch(file_, world, pressed);
}

}  // namespace turgor

#include "turgor/sim/recording/recording.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/models/lattice/build/cell_laws.hpp"
#include "turgor/sim/recording/recording_cloth.hpp"
#include "turgor/sim/recording/recording_lattice.hpp"
#include "turgor/sim/recording/recording_suture.hpp"
#include "turgor/sim/recording/recording_touch.hpp"
#include "turgor/sim/scene/scene_cells.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

constexpr const char *kRecordingFormat = "turgor recording 7",
                     *kOldFormat = "turgor recording 6";  // the same with the names of renamed_datasets.hpp
constexpr std::size_t kMostSnapshots = 1000000, kMostPathPoints = 1 << 24;
constexpr double kUnitError = 1e-6;  // of the length of a unit vector

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

Status write_cut(Hdf5File& file, const std::string& group, const Cut& cut) {
  const lattice::BladePath path = cut.path.value_or(lattice::BladePath{});
  TURGOR_CHECK(path.inward.size() == path.points.size(), "every point of a path has a direction");
  return Writing(file, fmt::format("{}/cuts/{}/", group, cut.blade.name))
      .array("path", flat(path.points), 3, "m")
      .array("into", flat(path.inward), 3)
      .array<double>("progress", {path.depth, cut.done, double(cut.edges)}, 1, "m, 1, 1")
      .status();
}

/// Gives lattices the kind of cells that was recorded, so that a replay does not depend on the default of
/// scenes. In recordings without it, cells are whole unless the scene chooses.
Status restore_cells(const Hdf5File& file, Scene& scene) {
  for (LatticeScene& lattice : scene.lattice_bodies) {
    Reading reading(file, fmt::format("/bodies/{}/", lattice.name));
    if (!file.has(reading.group() + "partial_cells")) {
      use_whole_cells(lattice);
      continue;
    }
    const auto stored = reading.array<std::int32_t>("partial_cells", 1);
    if (reading.status() && stored[0] != 0 && stored[0] != 1)
      reading.fail("partial_cells", fmt::format("expected 0 or 1, found {}", stored[0]));
    else if (reading.status() && stored[0] == 1 && lattice::has_cell_laws(lattice.params.tissue))
      reading.fail("partial_cells", "expected 0, since the laws of the body need whole cells");
    if (!reading.status()) return reading.status();
    set_recorded_cells(lattice, stored[0] != 0);
  }
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
  for (const ClothBody& body : world.cloth_bodies)
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

  // only outputs, looks and file locations may change
  for (const std::string& more : more_overrides) {
    const std::string key = more.substr(0, more.find('='));
    const auto ends_with = [&](const char* ending) { return key.ends_with(ending); };
    if (!key.starts_with("output.") && !ends_with(".ct") && !ends_with(".labels") &&
        !ends_with(".direction_field") && !(key.starts_with("body.") && ends_with(".wet")))
      return Error{fmt::format(
          "--set {}: a replay may only change output.*, body.*.wet and the locations of a body's files",
          key)};
  }
  std::vector<std::string> overrides = split_lines(texts[2]);
  overrides.insert(overrides.end(), more_overrides.begin(), more_overrides.end());
  // files of --set were relative to the folder of the recorded run; a recording always has one
  const fs::path folder = texts[3].empty() ? "." : texts[3];
  Result<Scene> scene = parse_scene(texts[1], texts[0], overrides, folder);
  if (!scene)
    return Error{fmt::format("{}: the recorded scene is invalid: {}", path_.string(), scene.error().message)};
  if (const Status cells = restore_cells(file_, *scene); !cells) return cells.error();
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
  for (const ClothBody& body : world.cloth_bodies)
    if (const Status mesh = check_body(file_, body); !mesh) return mesh;
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
  if (!std::all_of(progress.begin(), progress.end(), [](double x) { return std::isfinite(x); }))
    reading.fail("progress", "expected finite numbers");
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
  show_sections(exec, world, snapshot);
  return Done{};
}

Status Recording::restore_touch(World& world, std::vector<Pressed>& pressed) const {
  return read_touch(file_, world, pressed);
}

}  // namespace turgor

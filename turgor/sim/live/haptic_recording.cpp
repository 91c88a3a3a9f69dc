#include "turgor/sim/live/haptic_recording.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/io/files/unfinished.hpp"
#include "turgor/sim/live/haptic_log.hpp"
#include "turgor/sim/live/haptic_rows.hpp"
#include "turgor/sim/live/mouse_tools.hpp"
#include "turgor/sim/recording/recording_arrays.hpp"
#include "turgor/sim/report/json_numbers.hpp"
#include "turgor/sim/scene/scene_cells.hpp"
#include "turgor/sim/tools/touch_log.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

constexpr const char *kHapticFormat = "turgor haptic recording 2",
                     *kOldFormat = "turgor felt run 1";  // renamed_datasets.hpp; check_words: ok
constexpr std::size_t kMostTools = 1000, kMostFrames = std::size_t(1) << 24, kMostLines = 1000;
constexpr std::size_t kRowsAtOnce = 8192;
constexpr const char *kDefaultCells = "/scene/default_cells",  // older recordings lack it: kWhole
    *kPartial = "partial", *kWhole = "whole";
constexpr const char* kTickUnits = "s, s, m, m, m, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1";

Json json_of(Vec3d v) { return Json::array({v.x, v.y, v.z}); }
Vec3d vector_of(const Json& json) {
  return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

Json json_of(const CutRequest& request) {
  const lattice::Incision& b = request.blade;
  Json path = Json::array();
  for (const Vec3d p : b.path) path.push_back(json_of(p));
  return {{"cut", request.body},
          {"name", b.name},
          {"from", json_of(b.from)},
          {"to", json_of(b.to)},
          {"path", path},
          {"depth", b.depth},
          {"tilt", b.tilt},
          {"width", b.width},
          {"duration", b.duration},
          {"through_bone", b.through_bone},
          {"undermine", {b.undermine.width, b.undermine.depth}}};
}
Json json_of(const WindRequest& request) {
  Json json = {{"wind", request.body}};
  if (request.velocity) json["velocity"] = json_of(*request.velocity);
  return json;
}
Json json_of(const ChangeRequest& request) {
  Json json = {{"change", request.key}};
  if (request.value) json["value"] = *request.value;
  return json;
}
Json json_of(const UndoCutRequest&) { return {{"undo_cut", true}}; }
Json json_of(const StitchRequest& request) {
  Json points = Json::array();
  for (const Vec3d p : request.through) points.push_back(json_of(p));
  Json json = {{"stitch", request.body},
               {"through", points},
               {"thread", request.thread},
               {"duration", request.duration}};
  if (request.wound) json["wound"] = *request.wound;
  if (request.tension) json["tension"] = *request.tension;
  return json;
}
Json json_of(const TightenRequest& request) {
  Json json = {{"tighten", request.suture}, {"duration", request.duration}};
  if (request.tension) json["tension"] = *request.tension;
  return json;
}
Json json_of(const UndoStitchRequest&) { return {{"undo_stitch", true}}; }

template <class Number>
void take(const Json& json, const char* key, std::optional<Number>& value) {
  if (json.contains(key)) value = json.at(key).get<Number>();
}
StitchRequest stitch_of(const Json& json) {
  StitchRequest request{.body = json.at("stitch").get<int>(),
                        .thread = json.at("thread").get<std::string>(),
                        .duration = json.at("duration").get<double>()};
  for (const Json& p : json.at("through")) request.through.push_back(vector_of(p));
  take(json, "wound", request.wound), take(json, "tension", request.tension);
  return request;
}
TightenRequest tighten_of(const Json& json) {
  TightenRequest request{.suture = json.at("tighten").get<int>(),
                         .duration = json.at("duration").get<double>()};
  take(json, "tension", request.tension);
  return request;
}

CutRequest cut_of(const Json& json) {
  CutRequest request{.blade = {.name = json.at("name").get<std::string>(),
                               .from = vector_of(json.at("from")),
                               .to = vector_of(json.at("to"))},
                     .body = json.at("cut").get<int>()};
  for (const Json& p : json.at("path")) request.blade.path.push_back(vector_of(p));
  request.blade.depth = json.at("depth").get<double>(), request.blade.tilt = json.at("tilt").get<double>();
  request.blade.width = json.at("width").get<double>(),
  request.blade.duration = json.at("duration").get<double>();
  request.blade.through_bone = json.value("through_bone", true);  // older recordings cut through bone
  if (json.contains("undermine"))
    request.blade.undermine = {json.at("undermine").at(0).get<double>(),
                               json.at("undermine").at(1).get<double>()};
  return request;
}

WorldRequest request_of(const Json& json) {
  if (json.contains("cut")) return cut_of(json);
  if (json.contains("wind")) {
    WindRequest wind{json.at("wind").get<int>(), std::nullopt};
    if (json.contains("velocity")) wind.velocity = vector_of(json.at("velocity"));
    return wind;
  }
  if (json.contains("undo_cut")) return UndoCutRequest{};
  if (json.contains("stitch")) return stitch_of(json);
  if (json.contains("tighten")) return tighten_of(json);
  if (json.contains("undo_stitch")) return UndoStitchRequest{};
  ChangeRequest change{json.at("change").get<std::string>(), std::nullopt};
  if (json.contains("value")) change.value = json.at("value").get<std::string>();
  return change;
}

std::string requests_text(const std::vector<RecordedRequest>& requests) {
  Json list = Json::array();
  for (const RecordedRequest& request : requests) {
    Json one = std::visit([](const auto& what) { return json_of(what); }, request.what);
    one["frame"] = request.frame;
    list.push_back(std::move(one));
  }
  return list.dump();
}

Result<std::vector<RecordedRequest>> requests_of(const std::string& text) {
  try {
    std::vector<RecordedRequest> requests;
    for (const Json& one : Json::parse(text))
      requests.push_back({one.at("frame").get<int>(), request_of(one)});
    return requests;
  } catch (const Json::exception&) {
    return Error{"/requests is damaged"};
  }
}

/// Writes ticks in blocks, so that an hour of them needs no more memory than a few seconds.
Status write_ticks(Hdf5File& file, const std::string& group, const DiskLog<HapticTick>& ticks) {
  Status status = Done{};
  std::size_t next = 0;
  do {
    // one block
    const std::size_t end = std::min(next + kRowsAtOnce, ticks.size());
    std::vector<double> rows;
    std::vector<std::int32_t> inputs, solutions;
    for (; next < end; next++) {
      append_row(ticks[next], rows);
      inputs.insert(inputs.end(), {ticks[next].inputs_used.frame, ticks[next].inputs_used.patch});
      solutions.push_back(ticks[next].inputs_used.solution);
    }
    // at the end of both datasets
    status = file.append<double>(group + "ticks", rows, kHapticNumbers);
    if (status) status = file.append<std::int32_t>(group + "tick_inputs", inputs, 2);
    if (status) status = file.append<std::int32_t>(group + "tick_solutions", solutions, 1);
  } while (next < ticks.size() && status);
  return status ? file.write_attribute(group + "ticks", "unit", kTickUnits) : status;
}

Status write_tool(Hdf5File& file, std::size_t n, const HapticTool& tool) {
  const std::string group = fmt::format("/tools/{:05}/", n);
  if (const Status written = write_ticks(file, group, tool.ticks); !written) return written;
  std::vector<std::int32_t> frames;
  for (const FrameInputs& inputs_used : tool.frames)
    frames.insert(frames.end(), {inputs_used.ticks, inputs_used.patches});
  return Writing(file, group).text("name", tool.name).array("frame_inputs", frames, 2).status();
}

/// Recording of a tool. It has no ticks if the tool touches no body.
Result<HapticTool> read_tool(const Hdf5File& file, std::size_t n) {
  Reading reading(file, fmt::format("/tools/{:05}/", n));

  // datasets
  const std::size_t ticks = reading.count("tick_inputs", 2 * kMostTicks) / 2;
  const std::size_t frames = reading.count("frame_inputs", 2 * kMostFrames) / 2;
  const auto rows = reading.array<double>("ticks", kHapticNumbers * ticks);
  const auto tick_inputs = reading.array<std::int32_t>("tick_inputs", 2 * ticks);
  const auto frame_inputs = reading.array<std::int32_t>("frame_inputs", 2 * frames);
  std::vector<std::int32_t> solutions(ticks, -1);  // older recordings have none
  if (file.has(reading.group() + "tick_solutions"))
    solutions = reading.array<std::int32_t>("tick_solutions", ticks);
  const Result<std::string> name = file.read_text(reading.group() + "name");
  if (!name) return name.error();
  if (!reading.status()) return reading.status().error();

  // ticks with their inputs
  HapticTool tool{.name = *name, .ticks = {}, .frames = {}};
  for (std::size_t i = 0; i < ticks; i++) {
    HapticTick tick = tick_of_row(std::span(rows).subspan(kHapticNumbers * i, kHapticNumbers));
    tick.inputs_used = {tick_inputs[2 * i], tick_inputs[2 * i + 1], solutions[i]};
    if (!is_sound(tick)) return Error{fmt::format("{}ticks: row {} is invalid", reading.group(), i + 1)};
    tool.ticks.append(tick);
  }

  // frames with their inputs
  for (std::size_t i = 0; i < frames; i++)
    tool.frames.push_back({frame_inputs[2 * i], frame_inputs[2 * i + 1]});
  return tool;
}

Result<HapticRecording> read_content(const Hdf5File& file) {
  HapticRecording run;

  // texts
  std::string file_text, folder_text, overrides, requests;
  for (const auto& [name, text] : {std::pair{"/scene/file", &file_text},
                                   {"/scene/folder", &folder_text},
                                   {"/scene/text", &run.text},
                                   {"/scene/overrides", &overrides},
                                   {"/requests", &requests}}) {
    Result<std::string> read = file.read_text(stored_path(file, name));
    if (!read) return read.error();
    *text = std::move(*read);
  }
  run.file = file_text, run.folder = folder_text;

  // default of cells
  run.has_whole_cells = !file.has(kDefaultCells);
  if (!run.has_whole_cells) {
    const Result<std::string> cells = file.read_text(kDefaultCells);
    if (!cells || (*cells != kPartial && *cells != kWhole))
      return Error{fmt::format("{}: expected \"{}\" or \"{}\"", kDefaultCells, kPartial, kWhole)};
    run.has_whole_cells = *cells == kWhole;
  }

  // overrides
  const Json lines = Json::parse(overrides, nullptr, false);
  if (!lines.is_array() || lines.size() > kMostLines) return Error{"/scene/overrides is damaged"};
  for (const Json& line : lines)
    if (line.is_string()) run.overrides.push_back(line.get<std::string>());

  // requests
  Result<std::vector<RecordedRequest>> recorded = requests_of(requests);
  if (!recorded) return recorded.error();
  run.requests = std::move(*recorded);

  // counts
  Reading reading(file, "/");
  const auto counts = reading.array<std::int32_t>("counts", 3);
  const auto hash = reading.array<std::uint64_t>("state_hash", 1);
  if (!reading.status()) return reading.status().error();
  if (counts[0] < 1 || std::size_t(counts[0]) > kMostFrames || counts[1] < 0 ||
      std::size_t(counts[1]) > kMostTools)
    return Error{"/counts is damaged"};
  run.frames = counts[0], run.has_mouse_tools = counts[2] != 0, run.hash = hash[0];

  // tools
  for (std::size_t t = 0; t < std::size_t(counts[1]); t++) {
    Result<HapticTool> tool = read_tool(file, t);
    if (!tool) return tool.error();
    run.tools.push_back(std::move(*tool));
  }
  return run;
}

/// Checks that frame inputs refer to existing ticks in ascending order, and that ticked tools have inputs for
/// every frame.
Status check_lengths(const HapticRecording& run) {
  for (const HapticTool& tool : run.tools) {
    std::int32_t before = 0;
    for (const FrameInputs& inputs_used : tool.frames) {
      if (inputs_used.ticks < before || std::size_t(inputs_used.ticks) > tool.ticks.size())
        return Error{fmt::format("/tools: frame inputs refer to missing ticks of {}", tool.name)};
      before = inputs_used.ticks;
    }
    if (!tool.ticks.empty() && tool.frames.size() != std::size_t(run.frames))
      return Error{fmt::format("/tools: expected {} frames of {}, found {}", run.frames, tool.name,
                               tool.frames.size())};
  }
  return Done{};
}

}  // namespace

void set_scene(const Scene& scene, bool has_mouse_tools, HapticRecording& run) {
  std::error_code ignored;
  run.file = fs::absolute(scene.file, ignored), run.folder = fs::current_path(ignored);
  run.text = scene.text, run.overrides = scene.overrides;
  run.has_mouse_tools = has_mouse_tools, run.has_whole_cells = scene.has_whole_cells;
}

Result<Scene> scene_of(const HapticRecording& run) {
  const fs::path folder = run.folder.empty() ? "." : run.folder;  // a recording always has one
  Result<Scene> scene = parse_scene(run.text, run.file, run.overrides, folder);
  if (!scene) return scene;
  TURGOR_CHECK(scene->frame_rate > 0, "a scene has a frame rate");
  scene->duration = run.frames / scene->frame_rate;
  if (run.has_whole_cells) use_whole_cells(*scene);
  return run.has_mouse_tools ? with_mouse_tools(*scene) : *scene;
}

namespace {

Status write_into(Unfinished& partial, const HapticRecording& run) {
  Result<Hdf5File> file = Hdf5File::create(partial.path());
  if (!file) return file.error();
  partial.hold();
  // write scene, requests and counts
  Status status = Writing(*file, "/")
                      .text("format", kHapticFormat)
                      .text("scene/file", run.file.string())
                      .text("scene/folder", run.folder.string())
                      .text("scene/text", run.text)
                      .text("scene/overrides", Json(run.overrides).dump())
                      .text("scene/default_cells", run.has_whole_cells ? kWhole : kPartial)
                      .text("requests", requests_text(run.requests))
                      .array<std::int32_t>("counts", {run.frames, std::int32_t(run.tools.size()),
                                                      std::int32_t(run.has_mouse_tools)})
                      .array<std::uint64_t>("state_hash", {run.hash})
                      .status();
  // write the tools
  for (std::size_t t = 0; t < run.tools.size() && status; t++) status = write_tool(*file, t, run.tools[t]);
  return status ? file->close() : status;
}

}  // namespace

Status write_haptic_recording(const fs::path& path, const HapticRecording& run) {
  if (run.frames < 1) return Error{"no haptic recording: no frame was simulated yet"};
  Unfinished partial(path);
  if (const Status written = write_into(partial, run); !written)
    return Error{fmt::format("{}: the haptic recording cannot be written", path.string())};
  return partial.keep([&]() -> Result<fs::path> {
    std::error_code failed;
    fs::rename(partial.path(), path, failed);
    if (failed) return Error{fmt::format("{}: {}", path.string(), failed.message())};
    return path;
  });
}

Result<HapticRecording> read_haptic_recording(const fs::path& path) {
  if (is_haptic_log(path)) {
    Result<HapticRecording> run = read_haptic_log(path);
    const Status sound = run ? check_lengths(*run) : Status(Done{});
    return sound ? run : Error{fmt::format("{}: {}", path.string(), sound.error().message)};
  }
  const Result<Hdf5File> file = Hdf5File::open(path);
  if (!file) return file.error();
  const Result<std::string> format = file->read_text("/format");
  if (!format || (*format != kHapticFormat && *format != kOldFormat))
    return Error{fmt::format("{}: expected \"{}\", found another HDF5 file", path.string(), kHapticFormat)};
  Result<HapticRecording> run = read_content(*file);
  Status sound = Done{};
  if (run) sound = check_lengths(*run);
  if (!run || !sound)
    return Error{fmt::format("{}: {}", path.string(), (run ? sound.error() : run.error()).message)};
  return run;
}

}  // namespace turgor

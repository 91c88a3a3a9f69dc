#include "turgor/sim/live/haptic_recording.hpp"

#include <cmath>

#include <fmt/format.h>

#include "turgor/io/files/unfinished.hpp"
#include "turgor/sim/live/mouse_tools.hpp"
#include "turgor/sim/recording/recording_arrays.hpp"
#include "turgor/sim/report/json_numbers.hpp"
#include "turgor/sim/tools/touch_log.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

constexpr const char* kFeltFormat = "turgor felt run 1";
constexpr std::size_t kMostTools = 1000, kMostFrames = std::size_t(1) << 24, kMostLines = 1000;
constexpr std::size_t kNumbers = 16;  // of a tick: time, step, place, axes, grip, hold
constexpr const char* kTickUnits = "s, s, m, m, m, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1";

Json json_of(Vec3d v) { return Json::array({v.x, v.y, v.z}); }
Vec3d vector_of(const Json& json) {
  return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

Json json_of(const CutRequest& request) {
  const lattice::Incision& b = request.blade;
  Json path = Json::array();
  for (const Vec3d p : b.path) path.push_back(json_of(p));
  return {{"cut", request.body}, {"name", b.name},   {"from", json_of(b.from)},
          {"to", json_of(b.to)}, {"path", path},     {"depth", b.depth},
          {"tilt", b.tilt},      {"width", b.width}, {"duration", b.duration}};
}
Json json_of(const WindRequest& request) {
  return {{"wind", request.body}, {"velocity", json_of(request.velocity)}};
}
Json json_of(const ChangeRequest& request) { return {{"change", request.key}, {"value", request.value}}; }

CutRequest cut_of(const Json& json) {
  CutRequest request{.blade = {.name = json.at("name").get<std::string>(),
                               .from = vector_of(json.at("from")),
                               .to = vector_of(json.at("to"))},
                     .body = json.at("cut").get<int>()};
  for (const Json& p : json.at("path")) request.blade.path.push_back(vector_of(p));
  request.blade.depth = json.at("depth").get<double>(), request.blade.tilt = json.at("tilt").get<double>();
  request.blade.width = json.at("width").get<double>(),
  request.blade.duration = json.at("duration").get<double>();
  return request;
}

WorldRequest ask_of(const Json& json) {
  if (json.contains("cut")) return cut_of(json);
  if (json.contains("wind")) return WindRequest{json.at("wind").get<int>(), vector_of(json.at("velocity"))};
  return ChangeRequest{json.at("change").get<std::string>(), json.at("value").get<std::string>()};
}

std::string asks_text(const std::vector<RecordedRequest>& requests) {
  Json list = Json::array();
  for (const RecordedRequest& request : requests) {
    Json one = std::visit([](const auto& what) { return json_of(what); }, request.what);
    one["frame"] = request.frame;
    list.push_back(std::move(one));
  }
  return list.dump();
}

Result<std::vector<RecordedRequest>> asks_of(const std::string& text) {
  try {
    std::vector<RecordedRequest> requests;
    for (const Json& one : Json::parse(text)) requests.push_back({one.at("frame").get<int>(), ask_of(one)});
    return requests;
  } catch (const Json::exception&) {
    return Error{"what was asked for is damaged"};
  }
}

std::vector<double> rows_of(const std::vector<HapticTick>& ticks) {
  std::vector<double> rows;
  rows.reserve(kNumbers * ticks.size());
  for (const HapticTick& tick : ticks) {
    const contact::Pose& pose = tick.command.pose;
    rows.insert(rows.end(), {tick.time, tick.step});
    for (const Vec3d v : {pose.position, pose.axes.column[0], pose.axes.column[1], pose.axes.column[2]})
      rows.insert(rows.end(), {v.x, v.y, v.z});
    rows.insert(rows.end(), {tick.command.grip, double(tick.command.hold)});
  }
  return rows;
}

HapticTick tick_of(std::span<const double> row) {
  const auto vector = [&row](std::size_t at) { return Vec3d{row[at], row[at + 1], row[at + 2]}; };
  return {.time = row[0],
          .step = row[1],
          .command = {.pose = {vector(2), {{vector(5), vector(8), vector(11)}}},
                      .grip = row[14],
                      .hold = row[15] != 0},
          .inputs_used = {}};
}

Status write_tool(Hdf5File& file, std::size_t n, const HapticTool& tool) {
  std::vector<std::int32_t> ticks, frames;
  for (const HapticTick& tick : tool.ticks)
    ticks.insert(ticks.end(), {tick.inputs_used.frame, tick.inputs_used.patch});
  for (const FrameInputs& inputs_used : tool.frames)
    frames.insert(frames.end(), {inputs_used.ticks, inputs_used.patches});
  return Writing(file, fmt::format("/tools/{:05}/", n))
      .text("name", tool.name)
      .array("ticks", rows_of(tool.ticks), kNumbers, kTickUnits)
      .array("ticks_knew", ticks, 2)
      .array("frames_knew", frames, 2)
      .status();
}

bool is_sound(const HapticTick& tick) {
  return std::isfinite(tick.time) && tick.step > 0 && tick.step <= 1 && tick.command.grip >= 0 &&
         tick.command.grip <= 1;
}

/// A tool without ticks is one whose body was not felt.
Result<HapticTool> read_tool(const Hdf5File& file, std::size_t n) {
  Reading reading(file, fmt::format("/tools/{:05}/", n));
  const std::size_t ticks = reading.count("ticks_knew", 2 * kMostTicks) / 2;
  const std::size_t frames = reading.count("frames_knew", 2 * kMostFrames) / 2;
  const auto rows = reading.array<double>("ticks", kNumbers * ticks);
  const auto ticks_knew = reading.array<std::int32_t>("ticks_knew", 2 * ticks);
  const auto frames_knew = reading.array<std::int32_t>("frames_knew", 2 * frames);
  const Result<std::string> name = file.read_text(reading.group() + "name");
  if (!name) return name.error();
  if (!reading.status()) return reading.status().error();
  HapticTool tool{.name = *name, .ticks = {}, .frames = {}};
  for (std::size_t i = 0; i < ticks; i++) {
    HapticTick& tick = tool.ticks.emplace_back(tick_of(std::span(rows).subspan(kNumbers * i, kNumbers)));
    tick.inputs_used = {ticks_knew[2 * i], ticks_knew[2 * i + 1]};
    if (!is_sound(tick)) return Error{fmt::format("{}ticks: row {} is none", reading.group(), i + 1)};
  }
  for (std::size_t i = 0; i < frames; i++)
    tool.frames.push_back({frames_knew[2 * i], frames_knew[2 * i + 1]});
  return tool;
}

Result<HapticRecording> read_parts(const Hdf5File& file) {
  HapticRecording run;
  std::string file_text, folder_text, overrides, requests;
  for (const auto& [name, text] : {std::pair{"/scene/file", &file_text},
                                   {"/scene/folder", &folder_text},
                                   {"/scene/text", &run.text},
                                   {"/scene/overrides", &overrides},
                                   {"/asks", &requests}}) {
    Result<std::string> read = file.read_text(name);
    if (!read) return read.error();
    *text = std::move(*read);
  }
  run.file = file_text, run.folder = folder_text;
  const Json lines = Json::parse(overrides, nullptr, false);
  if (!lines.is_array() || lines.size() > kMostLines) return Error{"/scene/overrides is damaged"};
  for (const Json& line : lines)
    if (line.is_string()) run.overrides.push_back(line.get<std::string>());
  Result<std::vector<RecordedRequest>> asked = asks_of(requests);
  if (!asked) return asked.error();
  run.requests = std::move(*asked);
  Reading reading(file, "/");
  const auto counts = reading.array<std::int32_t>("counts", 3);
  const auto hash = reading.array<std::uint64_t>("state_hash", 1);
  if (!reading.status()) return reading.status().error();
  if (counts[0] < 1 || std::size_t(counts[0]) > kMostFrames || counts[1] < 0 ||
      std::size_t(counts[1]) > kMostTools)
    return Error{"/counts is damaged"};
  run.frames = counts[0], run.has_mouse_tools = counts[2] != 0, run.hash = hash[0];
  for (std::size_t t = 0; t < std::size_t(counts[1]); t++) {
    Result<HapticTool> tool = read_tool(file, t);
    if (!tool) return tool.error();
    run.tools.push_back(std::move(*tool));
  }
  return run;
}

/// Tools of one body tick together; frames know ticks that there are.
Status check_lengths(const HapticRecording& run) {
  for (const HapticTool& tool : run.tools) {
    std::int32_t before = 0;
    for (const FrameInputs& inputs_used : tool.frames) {
      if (inputs_used.ticks < before || std::size_t(inputs_used.ticks) > tool.ticks.size())
        return Error{fmt::format("/tools: frames know ticks of {} that are none", tool.name)};
      before = inputs_used.ticks;
    }
    if (!tool.ticks.empty() && tool.frames.size() != std::size_t(run.frames))
      return Error{fmt::format("/tools: expected {} frames of {}, found {}", run.frames, tool.name,
                               tool.frames.size())};
  }
  return Done{};
}

}  // namespace

void note_scene(const Scene& scene, bool has_mouse_tools, HapticRecording& run) {
  std::error_code ignored;
  run.file = fs::absolute(scene.file, ignored), run.folder = fs::current_path(ignored);
  run.text = scene.text, run.overrides = scene.overrides;
  run.has_mouse_tools = has_mouse_tools;
}

Result<Scene> scene_of(const HapticRecording& run) {
  Result<Scene> scene = parse_scene(run.text, run.file, run.overrides, run.folder);
  if (!scene) return scene;
  scene->duration = run.frames / scene->frame_rate;
  return run.has_mouse_tools ? with_mouse_tools(*scene) : *scene;
}

namespace {

Status write_into(const fs::path& path, const HapticRecording& run) {
  Result<Hdf5File> file = Hdf5File::create(path);
  if (!file) return file.error();
  Status status = Writing(*file, "/")
                      .text("format", kFeltFormat)
                      .text("scene/file", run.file.string())
                      .text("scene/folder", run.folder.string())
                      .text("scene/text", run.text)
                      .text("scene/overrides", Json(run.overrides).dump())
                      .text("asks", asks_text(run.requests))
                      .array<std::int32_t>("counts", {run.frames, std::int32_t(run.tools.size()),
                                                      std::int32_t(run.has_mouse_tools)})
                      .array<std::uint64_t>("state_hash", {run.hash})
                      .status();
  for (std::size_t t = 0; t < run.tools.size() && status; t++) status = write_tool(*file, t, run.tools[t]);
  return status ? file->close() : status;
}

}  // namespace

Status write_haptic_recording(const fs::path& path, const HapticRecording& run) {
  if (run.frames < 1) return Error{"no felt run: no frame has passed yet"};
  Unfinished partial(path);
  if (const Status written = write_into(partial.path(), run); !written)
    return Error{fmt::format("{}: the felt run cannot be written", path.string())};
  return partial.keep([&]() -> Status {
    std::error_code failed;
    fs::rename(partial.path(), path, failed);
    if (failed) return Error{fmt::format("{}: {}", path.string(), failed.message())};
    return Done{};
  });
}

Result<HapticRecording> read_haptic_recording(const fs::path& path) {
  const Result<Hdf5File> file = Hdf5File::open(path);
  if (!file) return file.error();
  const Result<std::string> format = file->read_text("/format");
  if (!format || *format != kFeltFormat)
    return Error{fmt::format("{}: expected \"{}\", found another HDF5 file", path.string(), kFeltFormat)};
  Result<HapticRecording> run = read_parts(*file);
  Status sound = Done{};
  if (run) sound = check_lengths(*run);
  if (!run || !sound)
    return Error{fmt::format("{}: {}", path.string(), (run ? sound.error() : run.error()).message)};
  return run;
}

}  // namespace turgor

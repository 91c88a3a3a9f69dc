#include "turgor/sim/live/haptic_log.hpp"

#include <algorithm>
#include <atomic>
#include <cstring>
#include <fstream>
#include <string_view>

#include <fmt/format.h>

#include "turgor/io/files/file.hpp"
#include "turgor/io/files/unfinished.hpp"
#include "turgor/sim/live/haptic_rows.hpp"
#include "turgor/sim/report/json_numbers.hpp"
#include "turgor/sim/tools/touch_log.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kLogTitle = "turgor haptic log 2\n", kFrameMark = "FRAM";
constexpr std::string_view kOldTitle = "turgor haptic log 1\n";  // ticks without TickInputs::solution
constexpr const char* kLogKind = "haptic";
constexpr std::size_t kMostLoggedTools = 1000, kLongestHeader = std::size_t(1) << 26;
constexpr std::size_t kTickBytes = kHapticNumbers * sizeof(double) + sizeof(TickInputs);
static_assert(kOldTitle.size() == kLogTitle.size());

template <class T>
void add_bytes(const T& value, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}
template <class T>
T take_bytes(std::string_view& bytes) {
  T value{};
  if (bytes.size() < sizeof value) return bytes = {}, value;
  std::memcpy(&value, bytes.data(), sizeof value);
  bytes.remove_prefix(sizeof value);
  return value;
}

void add_tick(const HapticTick& tick, std::vector<double>& row, std::string& bytes) {
  row.clear();
  append_row(tick, row);
  bytes.append(reinterpret_cast<const char*>(row.data()), kHapticNumbers * sizeof(double));
  add_bytes(tick.inputs_used, bytes);
}

HapticTick take_tick(std::string_view& bytes, bool is_old) {
  std::vector<double> row(kHapticNumbers);
  for (double& number : row) number = take_bytes<double>(bytes);
  HapticTick tick = tick_of_row(row);
  tick.inputs_used.frame = take_bytes<std::int32_t>(bytes);
  tick.inputs_used.patch = take_bytes<std::int32_t>(bytes);
  if (!is_old) tick.inputs_used.solution = take_bytes<std::int32_t>(bytes);
  return tick;
}

Json header_of(const HapticRecording& run, const std::vector<int>& ticked) {
  Json names = Json::array();
  for (const HapticTool& tool : run.tools) names.push_back(tool.name);
  return {{"file", run.file.string()},
          {"folder", run.folder.string()},
          {"text", run.text},
          {"overrides", run.overrides},
          {"mouse", run.has_mouse_tools},
          {"whole_cells", run.has_whole_cells},
          {"tools", names},
          {"ticked", ticked}};
}

/// Content of a log while it is read.
struct LogContent {
  HapticRecording run;
  std::vector<std::size_t> ticked;  // indices into run.tools
  bool is_old = false;              // true: it begins with kOldTitle
};

/// Reads the header and removes it from the bytes. Empty if it is damaged.
std::optional<LogContent> take_header(std::string_view& bytes) {
  const auto length = take_bytes<std::uint64_t>(bytes);
  if (length > std::min(bytes.size(), kLongestHeader)) return {};
  try {
    const Json json = Json::parse(bytes.substr(0, length));
    bytes.remove_prefix(length);
    LogContent content;
    HapticRecording& run = content.run;
    run.file = json.at("file").get<std::string>(), run.folder = json.at("folder").get<std::string>();
    run.text = json.at("text").get<std::string>();
    run.overrides = json.at("overrides").get<std::vector<std::string>>();
    run.has_mouse_tools = json.at("mouse").get<bool>(), run.has_hash = false;
    run.has_whole_cells = json.value("whole_cells", true);  // older logs lack it
    for (const Json& name : json.at("tools"))
      run.tools.push_back({.name = name.get<std::string>(), .ticks = {}, .frames = {}});
    for (const Json& index : json.at("ticked")) content.ticked.push_back(index.get<std::size_t>());
    const bool is_known = std::all_of(content.ticked.begin(), content.ticked.end(),
                                      [&](std::size_t t) { return t < run.tools.size(); });
    if (!is_known || run.tools.size() > kMostLoggedTools || content.ticked.size() > run.tools.size())
      return {};
    return content;
  } catch (const Json::exception&) {
    return {};
  }
}

/// Reads a frame. False: damaged. A frame that is cut short ends the bytes.
bool take_frame(std::string_view& bytes, LogContent& content) {
  std::string_view now = bytes;
  if (now.size() < kFrameMark.size()) return bytes = {}, true;
  if (!now.starts_with(kFrameMark)) return false;
  now.remove_prefix(kFrameMark.size());
  const std::size_t ticks = take_bytes<std::uint32_t>(now), tools = content.ticked.size();
  const std::size_t tick_bytes = kTickBytes - (content.is_old ? sizeof(TickInputs::solution) : 0);
  if (now.size() / (std::max<std::size_t>(tools, 1) * tick_bytes) < ticks ||
      now.size() - ticks * tools * tick_bytes < tools * sizeof(FrameInputs))
    return bytes = {}, true;
  if (content.run.frames >= int(kMostTicks)) return false;
  for (std::size_t tick = 0; tick < ticks; tick++)
    for (const std::size_t tool : content.ticked) {
      const HapticTick one = take_tick(now, content.is_old);
      DiskLog<HapticTick>& all = content.run.tools[tool].ticks;
      if (!is_sound(one) || all.size() >= kMostTicks) return false;
      all.append(one);
    }
  for (const std::size_t tool : content.ticked)
    content.run.tools[tool].frames.push_back(take_bytes<FrameInputs>(now));
  content.run.frames++;
  bytes = now;
  return true;
}

/// Removes frames at the end that used ticks which were not logged any more.
void drop_incomplete_frames(LogContent& content) {
  const auto is_whole = [&](std::size_t t) {
    const HapticTool& tool = content.run.tools[t];
    return tool.frames.back().ticks >= 0 && std::size_t(tool.frames.back().ticks) <= tool.ticks.size();
  };
  while (content.run.frames > 0 && !std::all_of(content.ticked.begin(), content.ticked.end(), is_whole)) {
    for (const std::size_t t : content.ticked) content.run.tools[t].frames.pop_back();
    content.run.frames--;
  }
}

}  // namespace

HapticLogWriter::HapticLogWriter(const fs::path& goal, const HapticRecording& run,
                                 const std::vector<int>& ticked)
    : path_(hidden_beside(goal, kLogKind)), begin_(kLogTitle) {
  static std::atomic<unsigned> count{0};
  path_ += fmt::format("-{}", count++);
  const std::string header = header_of(run, ticked).dump(-1, ' ', false, Json::error_handler_t::replace);
  add_bytes(std::uint64_t(header.size()), begin_);
  begin_ += header;
}

/// Writes and gives the bytes to the system, so that they survive the end of the program.
void HapticLogWriter::write(const std::string& bytes) {
  failed_ = failed_ || std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size() ||
            std::fflush(file_.get()) != 0;
}

void HapticLogWriter::add_frame(std::span<const LoggedTool> tools) {
  // the file
  if (failed_) return;
  if (!file_) {
    file_.reset(std::fopen(path_.c_str(), "wbxe"));
    failed_ = !file_;
    if (failed_) return;
    write(begin_);
    say_when_interrupted(fmt::format("turgor replay {} repeats the run", path_.string()));
  }

  // ticks that all tools have
  std::size_t end = tools.empty() ? 0 : std::size_t(-1);
  for (const LoggedTool& tool : tools) end = std::min(end, tool.ticks->size());
  std::string bytes(kFrameMark);
  std::vector<double> row;
  add_bytes(std::uint32_t(end - ticks_), bytes);
  for (; ticks_ < end; ticks_++)
    for (const LoggedTool& tool : tools) add_tick((*tool.ticks)[ticks_], row, bytes);
  // inputs of the frame
  for (const LoggedTool& tool : tools) add_bytes(tool.frame, bytes);
  write(bytes);
}

void HapticLogWriter::remove() {
  std::error_code ignored;
  fs::remove(path_, ignored);
  say_when_interrupted("");
}

bool is_haptic_log(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return false;
  std::string begin(kLogTitle.size(), '\0');
  std::ifstream(path, std::ios::binary).read(begin.data(), std::streamsize(begin.size()));
  return begin == kLogTitle || begin == kOldTitle;
}

Result<HapticRecording> read_haptic_log(const fs::path& path) {
  const Result<std::string> file = read_file(path);
  if (!file) return file.error();
  std::string_view bytes(*file);
  const bool is_old = bytes.starts_with(kOldTitle);
  if (!is_old && !bytes.starts_with(kLogTitle))
    return Error{fmt::format("{}: expected a log of a haptic run, found another file", path.string())};
  bytes.remove_prefix(kLogTitle.size());
  std::optional<LogContent> content = take_header(bytes);
  if (content) content->is_old = is_old;
  while (content && !bytes.empty())
    if (!take_frame(bytes, *content)) content.reset();
  if (!content) return Error{fmt::format("{}: the log of the haptic run is damaged", path.string())};
  drop_incomplete_frames(*content);
  if (content->run.frames < 1)
    return Error{fmt::format("{}: the log of the haptic run has no complete frame", path.string())};
  return std::move(content->run);
}

std::vector<std::string> keep_haptic_logs(const fs::path& goal) {
  std::vector<std::string> sentences;
  std::error_code error;
  for (const fs::path& log : leftovers_beside(goal, kLogKind)) {
    const fs::path kept = unused_name_beside(goal, "haptic-log");
    fs::rename(log, kept, error);
    const fs::path& present = error ? log : kept;
    sentences.push_back(fmt::format(
        "an interrupted run left the log of its hand: turgor replay {} repeats it", present.string()));
  }
  return sentences;
}

}  // namespace turgor

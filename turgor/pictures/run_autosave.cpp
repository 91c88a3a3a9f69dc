#include "turgor/pictures/run_autosave.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "turgor/io/files/unfinished.hpp"
#include "turgor/pictures/transfer_outputs.hpp"
#include "turgor/sim/autosave/saved_world.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

/// Frames of a video, whose folder has another name in every run.
template <class File>
void transfer_film(File& file, const fs::path& folder, Film& film) {
  std::vector<std::string> names;
  for (const fs::path& frame : film.frames) names.push_back(frame.lexically_relative(folder).string());
  transfer(file, names);
  film.frames.clear();
  for (const std::string& name : names) film.frames.push_back(folder / name);
}

/// Growing series of meshes by file.
template <class File>
void transfer_series(File& file, std::map<std::string, VtkHdfProgress>& series) {
  std::vector<std::pair<std::string, VtkHdfProgress>> list(series.begin(), series.end());
  transfer(file, list);
  series = {list.begin(), list.end()};
}

template <class File>
void transfer_outputs(File& file, Outputs& outputs) {
  transfer_all(file, outputs.facts, outputs.first, outputs.series, outputs.animation, outputs.animation_ended,
               outputs.video_begin, outputs.video_end, outputs.motion);
  for (Film& film : outputs.films) transfer_film(file, outputs.folder, film);
}

/// Identity of the program that keeps runs.
std::string program_of_run() { return state_program({sizeof(Outputs)}); }

Status check_header(const fs::path& path, const Scene& scene, const AutosaveHeader& header) {
  if (header.program != program_of_run())
    return Error{
        fmt::format("{}: the autosave is of another program: expected {}, found {}; run without --resume "
                    "to start again",
                    path.string(), program_of_run(), header.program)};
  if (header.scene != scene.text || header.overrides != scene.overrides)
    return Error{
        fmt::format("{}: the autosave is of another scene, or of other --set, than {}; run without --resume "
                    "to start again",
                    path.string(), scene.file.string())};
  return Done{};
}

Error damaged(const fs::path& path) {
  return {fmt::format("{}: the autosave is damaged; run without --resume to start again", path.string())};
}

/// Files of the results that still grow.
std::vector<std::string> growing_files(const Outputs& outputs) {
  std::vector<std::string> names{"recording.h5"};
  for (const auto& [file, series] : outputs.vtkhdf) names.push_back(file);
  return names;
}

Status resume_series(const std::map<std::string, VtkHdfProgress>& series, Outputs& outputs) {
  for (const auto& [file, progress] : series) {
    Result<VtkHdfSeries> resumed =
        VtkHdfSeries::resume(outputs.folder / file, outputs.scene->output.mesh_space, progress);
    if (!resumed) return resumed.error();
    outputs.vtkhdf.emplace(file, std::move(*resumed));
  }
  return Done{};
}

}  // namespace

Result<std::optional<SavedRun>> find_saved_run(const fs::path& goal, const Scene& scene) {
  Result<std::optional<AutosaveFolder>> folder = AutosaveFolder::take_over(goal);
  if (!folder) return folder.error();
  if (!*folder) return std::optional<SavedRun>();
  const fs::path path = (*folder)->state_file();
  Result<StateReader> state = StateReader::open(path);
  if (!state) return state.error();
  AutosaveHeader header;
  transfer(*state, header);
  if (!state->is_sound()) return damaged(path);
  if (const Status same = check_header(path, scene, header); !same) return same.error();
  return std::optional<SavedRun>({std::move(**folder), std::move(*state), header.time, header.loaded_hash});
}

Result<std::optional<SavedRun>> choose_saved_run(const fs::path& goal, const Scene& scene, bool resume,
                                                 const std::function<void(const std::string&)>& note) {
  const auto tell_if = [&](bool condition, const std::string& sentence) {
    if (condition && note) note(sentence);
  };
  if (!resume) {
    const std::vector<fs::path> others = autosaves_beside(goal);
    tell_if(!others.empty(),
            fmt::format("{}: an earlier run was interrupted; --resume goes on with it until this "
                        "one is complete",
                        goal.string()));
    return std::optional<SavedRun>();
  }
  Result<std::optional<SavedRun>> saved = find_saved_run(goal, scene);
  if (!saved) return saved;
  tell_if(bool(*saved),
          fmt::format("resuming at {:.3f} s of {} s", *saved ? (*saved)->time : 0, scene.duration));
  tell_if(!*saved,
          fmt::format("{}: no autosave of an interrupted run: starting at the beginning", goal.string()));
  return saved;
}

Autosave::Autosave(AutosaveFolder folder, double interval, const Scene& scene, const World& loaded)
    : folder_(std::move(folder)),
      interval_(interval),
      next_(interval),
      scene_(scene),
      loaded_(loaded_patches(loaded)),
      loaded_hash_(loaded_hash(loaded)) {}

Status Autosave::restore(const Exec& exec, SavedRun& saved, World& world, UnfinishedRun& run) {
  // inputs
  const fs::path path = folder_.state_file();
  if (loaded_hash_ != saved.loaded_hash)
    return Error{
        fmt::format("{}: the inputs of the scene have changed since the autosave; run without --resume to "
                    "start again",
                    path.string())};

  // world, measures and outputs
  std::vector<SavedFile> files;
  std::map<std::string, VtkHdfProgress> series;
  int number = 0;
  transfer_all(saved.state, number, files, run.snapshots, run.seconds, run.simulation_seconds);
  read_world(exec, saved.state, loaded_, world);
  transfer_all(saved.state, run.simulated, run.stretch);
  transfer_outputs(saved.state, run.outputs);
  transfer_series(saved.state, series);
  if (!saved.state.is_at_end()) return damaged(path);

  // files
  folder_.set_number(number);
  const Status status = folder_.restore_files(files, run.outputs.folder);
  return status ? resume_series(series, run.outputs) : status;
}

Status Autosave::write_state(const World& world, UnfinishedRun& run) {
  // growing files
  std::map<std::string, VtkHdfProgress> series;
  for (auto& [file, open] : run.outputs.vtkhdf) {
    if (const Status flushed = open.flush(); !flushed) return flushed;
    series.emplace(file, open.progress());
  }
  Result<std::vector<SavedFile>> files = folder_.keep_files(run.outputs.folder, growing_files(run.outputs));
  if (!files) return files.error();

  // state
  Result<StateWriter> file = StateWriter::create(folder_.next_state_file());
  if (!file) return file.error();
  AutosaveHeader header{program_of_run(), scene_.text, scene_.overrides, time_of(world), loaded_hash_};
  int number = folder_.number() + 1;
  transfer_all(*file, header, number, *files, run.snapshots, run.seconds, run.simulation_seconds);
  write_world(*file, world, loaded_);
  transfer_all(*file, run.simulated, run.stretch);
  transfer_outputs(*file, run.outputs);
  transfer_series(*file, series);
  const Status closed = file->close();
  return closed ? folder_.replace_state() : closed;
}

void Autosave::remove() {
  folder_.remove_all();
  say_when_interrupted("");
}

Status Autosave::save(const World& world, UnfinishedRun run) {
  const Timer timer;
  const Status written = write_state(world, run);
  constexpr double kLargestCost = 0.05,
                   kShortest = 1;  // of the wall time [1] [s]; shorter ones are for tests
  next_ = interval_ < kShortest ? interval_ : std::max(interval_, timer.seconds() / kLargestCost);
  since_ = Timer();
  if (written)
    say_when_interrupted(
        fmt::format("--resume goes on at {:.3f} s of {} s", time_of(world), scene_.duration));
  return written;
}

}  // namespace turgor

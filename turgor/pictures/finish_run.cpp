#include "turgor/pictures/finish_run.hpp"

#include <fmt/format.h>

#include "turgor/io/files/file.hpp"
#include "turgor/io/files/unfinished.hpp"
#include "turgor/sim/output_manifest.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

/// Warning of results that have no pictures yet; the report that has them does not have it.
constexpr const char* kNoPicturesYet =
    "no pictures: the program ended while it drew them; turgor run --replay recording.h5 draws them";

Status write_report_and_page(const Timer& total, Json& report, Outputs& outputs) {
  const std::string motion = motion_of_page(outputs);
  outputs.facts.total_seconds = outputs.facts.resumed_after + total.seconds();
  add_outputs(report, outputs.facts);
  const Status status =
      write_file(outputs.folder / "report.html", report_html(report, outputs.folder, motion));
  return status ? write_file(outputs.folder / kReportFile, json_text(report) + "\n") : status;
}

/// Moves the outputs to another folder; the frames of videos are in it or follow.
void rebase(Outputs& outputs, const fs::path& folder) {
  for (Film& film : outputs.films)
    for (fs::path& frame : film.frames) frame = folder / frame.lexically_relative(outputs.folder);
  outputs.folder = folder;
}

/// Moves every file of a folder to its position in another one.
Status move_files(const fs::path& from, const fs::path& to) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(from, error)) {
    const fs::path goal = to / entry.path().lexically_relative(from);
    if (entry.is_directory(error))
      fs::create_directories(goal, error);
    else
      fs::rename(entry.path(), goal, error);
    if (error) break;
  }
  if (error) return Error{fmt::format("{}: cannot add the pictures: {}", to.string(), error.message())};
  fs::remove_all(from, error);
  return Done{};
}

/// Draws into the folder of the outputs.
Status draw_all_pictures(const FinishedRun& run, const RunCallbacks& callbacks) {
  const Progress progress = begin_work(callbacks.begin, "drawing");
  for (std::size_t s = 0; s < run.later.size(); s++) {
    draw_frames(run.later[s], run.outputs);
    if (progress) progress(double(s + 1) / double(run.later.size() + 1));
  }
  const Timer drawing;
  const Status status = draw_outputs(run.world, run.snapshot, run.pressed, run.outputs);
  run.outputs.facts.output_seconds += drawing.seconds();
  if (progress) progress(1);
  return status;
}

}  // namespace

Status commit_results(const Timer& total, const FinishedRun& run, const Json& report, OutputFolder& folder,
                      const RunCallbacks& callbacks) {
  const Timer writing;
  Outputs& outputs = run.outputs;
  Status status = write_outputs(run.world, run.snapshot, run.pressed, outputs);
  outputs.facts.output_seconds = writing.seconds();
  Json without_pictures = report;
  outputs.facts.warnings.push_back(kNoPicturesYet);
  if (status) status = write_report_and_page(total, without_pictures, outputs);
  outputs.facts.warnings.pop_back();
  if (status) status = folder.commit();
  if (status && callbacks.note && !folder.kept().empty()) callbacks.note(kept_note(folder));
  return status;
}

Status add_pictures_to_results(const Timer& total, const FinishedRun& run, Json& report,
                               const OutputFolder& folder, const RunCallbacks& callbacks) {
  // a hidden folder, which takes the frames of videos with it
  Unfinished drawn(folder.goal());
  std::error_code error;
  const bool has_frames = run.outputs.scene->output.frames;
  fs::create_directories(has_frames ? drawn.path() / "frames" : drawn.path(), error);
  if (error)
    return Error{fmt::format("{}: cannot make the folder: {}", drawn.path().string(), error.message())};
  drawn.hold();
  rebase(run.outputs, folder.goal());  // the committed folder has another name
  if (fs::exists(folder.goal() / kVideoFolder, error))
    fs::rename(folder.goal() / kVideoFolder, drawn.path() / kVideoFolder, error);
  rebase(run.outputs, drawn.path());
  // pictures, then everything under its final name
  Status status = draw_all_pictures(run, callbacks);
  if (status) status = write_report_and_page(total, report, run.outputs);
  if (!status)
    return Error{fmt::format("{}; the results without pictures are in {}", status.error().message,
                             folder.goal().string())};
  status = drawn.keep([&]() -> Result<fs::path> {
    const Status moved = move_files(drawn.path(), folder.goal());
    return moved ? Result<fs::path>(folder.goal()) : moved.error();
  });
  return status ? write_manifest(folder.goal()) : status;
}

}  // namespace turgor

// Opening and saving scenes, and the question about unsaved cuts, stitches and changes.
#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "turgor/io/files/file.hpp"
#include "turgor/sim/scene/markups.hpp"
#include "turgor/sim/scene/scene_edit.hpp"
#include "turgor/sim/scene/scene_key.hpp"
#include "turgor/window/viewer.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

constexpr const char* kNothingToSave = "nothing to save: no scene is loaded";

bool has_scene(const Viewer& viewer) { return viewer.now && viewer.now->scene; }

/// Cuts and stitches by hand, as tables of the scene.
std::string cuts_text(const Viewer& viewer) {
  const SessionStatus& now = *viewer.now;
  std::vector<SavedStitch> stitches;
  for (const HandStitch& stitch : now.stitches)
    stitches.push_back({.wound = stitch.request.wound.value_or(0),
                        .through = stitch.request.through,
                        .thread = stitch.request.thread,
                        .tension = stitch.request.tension,
                        .duration = stitch.request.duration});
  return incisions_text(*now.scene, now.cuts) + sutures_text(*now.scene, now.cuts, stitches);
}

/// Time at which the last pull of a stitch by hand ends in the saved scene [s].
double end_of_stitches(const SessionStatus& now) {
  double end = 0;
  for (const HandStitch& stitch : now.stitches) {
    const auto wound = std::size_t(stitch.request.wound.value_or(0)), own = now.scene->incisions.size();
    const lattice::Incision* blade = wound < own                     ? &now.scene->incisions[wound].blade
                                     : wound - own < now.cuts.size() ? &now.cuts[wound - own]
                                                                     : nullptr;
    if (!blade) continue;
    const double cut = wound < own ? blade->start + blade->duration : blade->duration;
    end = std::max(end, cut + stitch.request.duration);
  }
  return end;
}

bool has_edits_by_hand(const Viewer& viewer) {
  return !viewer.now->cuts.empty() || !viewer.now->stitches.empty();
}

bool has_unsaved_cuts(const Viewer& viewer) {
  return has_scene(viewer) && cuts_text(viewer) != viewer.document.saved_cuts;
}

fs::path normal(const fs::path& file) {
  std::error_code ignored;
  return fs::absolute(file, ignored).lexically_normal();
}

/// File that Save writes.
fs::path file_of(const Viewer& viewer) {
  return viewer.document.file.empty() ? viewer.now->scene->file : viewer.document.file;
}

/// Overrides that make relative file names of a scene absolute, for a copy in another folder.
std::vector<std::string> absolute_names(const Scene& scene) {
  std::vector<std::string> overrides;
  for (const SceneKey& key : scene_keys(scene.text, scene.file)) {
    const std::string value = scene_value(scene, key.path);
    if (value.size() < 3 || value.front() != '"' || value.back() != '"') continue;
    const fs::path name = value.substr(1, value.size() - 2);
    std::error_code ignored;
    const fs::path file = fs::absolute(scene.file.parent_path() / name, ignored);
    if (name.has_extension() && name.is_relative() && fs::exists(file, ignored))
      overrides.push_back(fmt::format("{}=\"{}\"", key.path, file.lexically_normal().string()));
  }
  return overrides;
}

/// Scene with its changes and cuts. Error: a change that the text cannot take.
Result<std::string> text_with_edits(const Viewer& viewer, bool moves) {
  if (!has_scene(viewer)) return Error{std::string(kNothingToSave)};
  const Scene& scene = *viewer.now->scene;
  std::vector<std::string> overrides = scene.overrides;
  if (moves)
    for (std::string& name : absolute_names(scene)) overrides.push_back(std::move(name));
  if (const double end = end_of_stitches(*viewer.now); end >= scene.duration)
    overrides.push_back(fmt::format("world.duration={:.6g}", end + 1));  // a run pulls the stitches
  Result<std::string> text = with_values(scene.text, scene.file, overrides);
  if (text) *text += cuts_text(viewer);
  return text;
}

/// Writes the scene to a file. Error: the text would be no valid scene.
Status write_scene(Viewer& viewer, const fs::path& file) {
  const bool moves =
      has_scene(viewer) && normal(file).parent_path() != normal(viewer.now->scene->file).parent_path();
  const Result<std::string> text = text_with_edits(viewer, moves);
  if (!text) return text.error();
  const Result<Scene> sound = parse_scene(*text, file);
  if (!sound) return Error{"not saved: " + sound.error().message};
  if (const Status written = write_file(file, *text); !written) return written;
  viewer.document.saved_overrides = viewer.now->scene->overrides;
  viewer.document.saved_cuts = cuts_text(viewer);
  viewer.document.text = *text;
  return Done{};
}

/// True if another program changed the file since it was read or written.
bool is_changed_elsewhere(const Viewer& viewer, const fs::path& file) {
  const Document& document = viewer.document;
  const Result<std::string> text = read_file(file);
  return text && *text != (document.text.empty() ? viewer.now->scene->text : document.text);
}

void open_next(Viewer& viewer) {
  Document& document = viewer.document;
  viewer.session.request(OpenRequest{.file = document.next, .overrides = {}});
  viewer.message = "opening " + document.next.string();
  viewer.framed_file.clear(), viewer.shows_gallery = false;
  document.file.clear(), document.text.clear(), document.is_example = document.next_is_example;
  add_recent(document.next, viewer.settings);
}

/// Reads the scene's file again, which is another one after Save as.
void read_again(Viewer& viewer) {
  Document& document = viewer.document;
  if (!document.file.empty()) {
    document.next = document.file, document.next_is_example = false;
    return open_next(viewer);
  }
  viewer.session.request(ReloadRequest{});
  viewer.message = "scene file reloaded";
  document.text.clear(), document.saved_cuts.clear();
}

void ask_or_leave(Viewer& viewer, Leaving leaving, bool asks) {
  viewer.document.leaving = leaving;
  if (!asks) leave(viewer);
}

}  // namespace

bool has_unsaved_edits(const Viewer& viewer) {
  return has_scene(viewer) &&
         (has_unsaved_cuts(viewer) || viewer.now->scene->overrides != viewer.document.saved_overrides);
}

void open_file(Viewer& viewer, const fs::path& file) {
  if (is_markups_file(file)) return cut_along_markup(viewer, file);
  viewer.document.next = file, viewer.document.next_is_example = false;
  ask_or_leave(viewer, Leaving::kOpen, has_unsaved_edits(viewer));
}

void open_example(Viewer& viewer, const fs::path& file) {
  viewer.document.next = file, viewer.document.next_is_example = true;
  ask_or_leave(viewer, Leaving::kOpen, has_unsaved_edits(viewer));
}

void quit(Viewer& viewer) { ask_or_leave(viewer, Leaving::kQuit, has_unsaved_edits(viewer)); }

/// Changes survive a restart, cuts do not.
void restart(Viewer& viewer) {
  ask_or_leave(viewer, Leaving::kRestart, has_unsaved_cuts(viewer) && has_edits_by_hand(viewer));
}

void reload(Viewer& viewer) {
  ask_or_leave(viewer, Leaving::kReload, has_unsaved_cuts(viewer) && has_edits_by_hand(viewer));
}

void leave(Viewer& viewer) {
  Document& document = viewer.document;
  switch (std::exchange(document.leaving, Leaving::kNothing)) {
    case Leaving::kNothing:
      return;
    case Leaving::kQuit:
      viewer.ends = true;
      return;
    case Leaving::kRestart:
      // a saved file has the cuts that were made since it was read
      if (!document.text.empty()) return read_again(viewer);
      viewer.session.request(ResetRequest{});
      viewer.message = "restarted";
      return;
    case Leaving::kReload:
      return read_again(viewer);
    case Leaving::kOpen:
      open_next(viewer);
  }
}

void meet_document(Viewer& viewer) {
  viewer.document.opened_overrides = viewer.document.saved_overrides = viewer.now->scene->overrides;
  viewer.document.saved_cuts.clear();
}

void save(Viewer& viewer) {
  if (!has_scene(viewer)) return void(viewer.message = viewer.failure = kNothingToSave);
  if (viewer.document.is_example) return show_save_dialog(viewer);
  const fs::path file = file_of(viewer);
  if (is_changed_elsewhere(viewer, file)) {
    viewer.message = viewer.failure =
        file.string() + " was changed by another program: R reloads it, Save as keeps both";
    return;
  }
  save_as(viewer, file);
}

void save_as(Viewer& viewer, const fs::path& file) {
  const Status written = write_scene(viewer, file);
  if (!written) return void(viewer.message = viewer.failure = written.error().message);
  viewer.message = "saved " + file.string();
  viewer.document.file = normal(file) == normal(viewer.now->scene->file) ? fs::path() : file;
  viewer.document.is_example = false;
  add_recent(file, viewer.settings);
}

void save_new(Viewer& viewer, const fs::path& file) {
  std::error_code ignored;
  const bool is_own =
      has_scene(viewer) && !viewer.document.is_example && normal(file) == normal(file_of(viewer));
  if (!is_own && fs::exists(file, ignored))
    return void(viewer.message = viewer.failure =
                    "not saved: " + file.string() + " exists already; choose another name");
  save_as(viewer, file);
}

void save_copy(Viewer& viewer) {
  if (!has_scene(viewer)) return void(viewer.message = viewer.failure = kNothingToSave);
  const fs::path& file = viewer.now->scene->file;
  fs::path path;
  for (int n = 1; path.empty() || fs::exists(path); n++)
    path = file.parent_path() / fmt::format("{}-{}.toml", file.stem().string(), n);
  const std::string before = viewer.document.text;
  const Status written = write_scene(viewer, path);
  viewer.document.text = before;  // the document's own file is unchanged
  viewer.message = written ? "saved " + path.string() : written.error().message;
  if (!written) viewer.failure = viewer.message;
}

void show_open_dialog(Viewer& viewer) {
  const bool has_file = has_scene(viewer) && !viewer.now->scene->file.empty();
  open_dialog(FileDialog::Purpose::kOpen, has_file ? file_of(viewer).parent_path() : fs::path(), "",
              viewer.document.dialog);
}

void show_save_dialog(Viewer& viewer) {
  if (!has_scene(viewer)) return void(viewer.message = viewer.failure = kNothingToSave);
  const fs::path file = file_of(viewer);
  open_dialog(FileDialog::Purpose::kSave, file.parent_path(), file.filename().string(),
              viewer.document.dialog);
}

}  // namespace turgor

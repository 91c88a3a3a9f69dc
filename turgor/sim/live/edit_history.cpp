#include "turgor/sim/live/edit_history.hpp"

#include <utility>

#include <fmt/format.h>

namespace turgor {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostEdits = 200;

/// True for cuts, stitches and winds, which end with their world; changed values belong to the scene.
bool ends_with_world(const Edit& edit) { return !std::holds_alternative<ChangeRequest>(edit.redo); }

/// True if both change the same key, the wind of the same cloth or the pull of the same stitch.
bool is_same_key(const Edit& a, const Edit& b) {
  const auto *wind = std::get_if<WindRequest>(&a.redo), *next = std::get_if<WindRequest>(&b.redo);
  if (wind && next) return wind->body == next->body;
  const auto *pull = std::get_if<TightenRequest>(&a.redo), *again = std::get_if<TightenRequest>(&b.redo);
  if (pull && again) return pull->suture == again->suture;
  const auto *one = std::get_if<ChangeRequest>(&a.redo), *other = std::get_if<ChangeRequest>(&b.redo);
  return one && other && one->key == other->key;
}

std::string text_of(const std::vector<Edit>& edits) {
  if (edits.empty()) return {};
  if (const auto* change = std::get_if<ChangeRequest>(&edits.back().redo)) return change->key;
  const auto* wind = std::get_if<WindRequest>(&edits.back().redo);
  if (wind && wind->velocity) return fmt::format("wind of {:.1f} m/s", norm(*wind->velocity));
  if (const auto* stitch = std::get_if<StitchRequest>(&edits.back().redo))
    return fmt::format("stitch of {:.0f} mm", 1e3 * norm(stitch->through.back() - stitch->through.front()));
  if (const auto* pull = std::get_if<TightenRequest>(&edits.back().redo))
    return pull->tension ? fmt::format("tension of {:.1f} N", *pull->tension)
                         : std::string("pull until closed");
  const auto* cut = std::get_if<CutRequest>(&edits.back().redo);
  if (!cut) return {};
  const lattice::Incision& blade = cut->blade;
  double length = norm(blade.to - blade.from);
  if (!blade.path.empty()) length = 0;
  for (std::size_t n = 1; n < blade.path.size(); n++) length += norm(blade.path[n] - blade.path[n - 1]);
  return fmt::format("cut of {:.0f} mm", 1e3 * length);
}

}  // namespace

void add_edit(Edit edit, EditHistory& history) {
  constexpr auto kOneEdit = std::chrono::milliseconds(1000);  // longest pause within one edit
  const Clock::time_point now = Clock::now();
  const auto* pull = std::get_if<TightenRequest>(&edit.redo);
  const bool is_soon = now - history.latest < kOneEdit || (pull && pull->continues);
  const bool continues =
      !history.done.empty() && history.undone.empty() && is_same_key(history.done.back(), edit) && is_soon;
  history.undone.clear(), history.latest = now;
  if (continues) {
    history.done.back().redo = std::move(edit.redo);
    return;
  }
  history.done.push_back(std::move(edit));
  if (history.done.size() > kMostEdits) history.done.erase(history.done.begin());
}

void forget_world(EditHistory& history) {
  std::erase_if(history.done, ends_with_world);
  std::erase_if(history.undone, ends_with_world);
}

std::string undo_text(const EditHistory& history) { return text_of(history.done); }
std::string redo_text(const EditHistory& history) { return text_of(history.undone); }

}  // namespace turgor

// Cuts, stitches, winds and changes of a session that can be taken back and repeated. Changes of one key in
// quick succession, as of a slider that is being moved, count as one; likewise winds on one cloth and pulls
// of one stitch. All pulls of one drag are one edit, however long it takes.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "turgor/sim/live/requests.hpp"

namespace turgor {

/// A request, and the request that takes it back.
struct Edit {
  WorldRequest redo, undo;
};

struct EditHistory {
  std::vector<Edit> done, undone;                // latest last
  std::chrono::steady_clock::time_point latest;  // time of the latest edit
};

/// Adds an edit that was made now. Edits that were taken back can no longer be repeated.
void add_edit(Edit edit, EditHistory& history);
/// Forgets all cuts, stitches and winds, because their world ended.
void forget_world(EditHistory& history);

/// Description of the edit that is taken back or repeated next, such as "cut of 70 mm"; empty: none.
std::string undo_text(const EditHistory& history);
std::string redo_text(const EditHistory& history);

}  // namespace turgor

#include "turgor/sim/live/handle_requests.hpp"

#include <string>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "turgor/sim/live/change_world.hpp"
#include "turgor/sim/live/session_thread.hpp"

namespace turgor {

namespace {

void handle(const PaceRequest& request, SessionThread& session) {
  SessionStatus& next = session.next;
  next.plays = request.plays, next.pace = request.pace;
  if (!session.live.world) return;  // the reason why there is none stays
  if (next.plays) next.error.clear();
  set_pace(session);
}

void handle(const StepRequest&, SessionThread& session) {
  if (session.live.world && !session.next.plays) begin_single_step(session);
}

bool has_source(const SessionThread& session) { return !session.source.file.file.empty(); }

void handle(const ResetRequest&, SessionThread& session) { session.due.load = has_source(session); }

/// Reads the file again, also after a failed reading.
void handle(const ReloadRequest&, SessionThread& session) {
  SessionSource& source = session.source;
  if (source.scene) source.file.overrides = source.scene->overrides;
  source.scene.reset();
  session.history = {};
  session.due.load = has_source(session);
}

void handle(const OpenRequest& request, SessionThread& session) {
  session.source = {request, nullptr};
  session.next.plays = session.params.plays;
  session.history = {};
  session.due.load = true;
}

void handle(const CtRequest& request, SessionThread& session) {
  if (!session.live.world) return;
  update_ct(session.exec, *session.live.world, request.targets, SessionStatus::kMostSamples, session.ct);
  session.next.ct = session.ct.ct;
}

void handle(const CutawayRequest& request, SessionThread& session) { session.cutaway = request.cutaway; }

/// Applies a cut, a stitch, a wind or a changed value to the world. Reports the reason if that is impossible.
template <class AnyRequest>
bool apply(const AnyRequest& request, SessionThread& session) {
  if (!session.live.world) return false;
  World& world = *session.live.world;
  const Status status = apply_request(session.exec, request, session.source.scene, world);
  session.next.error = status ? "" : status.error().message;
  if (!status) return false;
  session.record.requests.push_back({world.frame, request});
  session.next.scene = session.source.scene;
  return true;
}

void handle(const CutRequest& request, SessionThread& session) {
  if (apply(request, session)) add_edit({request, UndoCutRequest{}}, session.history);
}

/// Request that restores the wind that blows now; the scene's unless a hand has changed it.
WindRequest wind_before(int body, const SessionThread& session) {
  const auto n = std::size_t(body);
  const ClothBody& cloth = session.live.world->cloth_bodies[n];
  const ClothScene& own = session.source.scene->cloth_bodies[n];
  if (cloth.air == own.air && cloth.turns == own.turns) return {body, std::nullopt};
  return {body, cloth.air.velocity};
}

void handle(const WindRequest& request, SessionThread& session) {
  const bool has_body = session.live.world && request.body >= 0 &&
                        std::size_t(request.body) < session.live.world->cloth_bodies.size();
  const WindRequest before = has_body ? wind_before(request.body, session) : request;
  if (apply(request, session)) add_edit({request, before}, session.history);
}

void handle(const StitchRequest& request, SessionThread& session) {
  if (apply(request, session)) add_edit({request, UndoStitchRequest{}}, session.history);
}

void handle(const TightenRequest& request, SessionThread& session) {
  if (!session.live.world) return;
  TightenRequest before{.suture = request.suture};
  if (const auto n = std::size_t(request.suture); n < session.live.world->sutures.size()) {
    const lattice::Pull& pull = session.live.world->sutures[n].scene.pull;
    if (!pull.until_closed) before.tension = pull.tension;
  }
  if (apply(request, session)) add_edit({request, before}, session.history);
}

/// After a cut was taken back, data computed from the cuts are computed again.
void forget_cut_data(SessionThread& session) {
  session.ct = {};
  session.next.ct.reset();
  session.next.undone_cuts++;
}

/// Applies one direction of an edit, and moves it to the other list. A refused pull is dropped: its stitch
/// tore, and would block all earlier edits.
void move_edit(std::vector<Edit>& from, std::vector<Edit>& to, bool undoes, SessionThread& session) {
  SessionStatus& next = session.next;
  next.edits++;
  if (from.empty()) {
    next.edited = undoes ? "nothing to undo" : "nothing to redo";
    return;
  }
  const std::string text = undoes ? undo_text(session.history) : redo_text(session.history);
  const char* verb = undoes ? "undone" : "repeated";
  const Edit edit = from.back();
  const bool applied =
      std::visit([&session](const auto& one) { return apply(one, session); }, undoes ? edit.undo : edit.redo);
  next.edited = applied ? fmt::format("{}: {}", verb, text) : fmt::format("not {}: {}", verb, next.error);
  if (!applied && !std::holds_alternative<TightenRequest>(edit.undo)) return;
  if (applied && undoes && std::holds_alternative<UndoCutRequest>(edit.undo)) forget_cut_data(session);
  from.pop_back();
  if (applied) to.push_back(edit);
}

void handle(const UndoRequest&, SessionThread& session) {
  move_edit(session.history.done, session.history.undone, true, session);
}

void handle(const RedoRequest&, SessionThread& session) {
  move_edit(session.history.undone, session.history.done, false, session);
}

/// Changes the world. Without a world, changes the scene that is loaded next.
void handle(const ChangeRequest& request, SessionThread& session) {
  if (session.live.world) {
    const ChangeRequest before{request.key, override_of(session.source.scene->overrides, request.key)};
    if (apply(request, session)) add_edit({request, before}, session.history);
    return;
  }
  std::shared_ptr<const Scene>& scene = session.source.scene;
  if (!scene) return;
  Result<Scene> changed = with_change(*scene, request.key, request.value);
  session.next.error = changed ? "" : changed.error().message;
  if (changed) session.next.scene = scene = std::make_shared<const Scene>(std::move(*changed));
}

void handle(const SaveRequest& request, SessionThread& session) {
  if (session.live.world) session.due.save = request.file;
}

bool has_due_work(const DueWork& due) { return due.load || due.save || due.step; }

}  // namespace

void handle_requests(SessionThread& session) {
  while (!session.batch.empty() && !has_due_work(session.due)) {
    const Request request = std::move(session.batch.front());
    session.batch.pop_front();
    std::visit([&session](const auto& one) { handle(one, session); }, request);
  }
}

}  // namespace turgor

// Stitches by hand: two points on the skin at both sides of a wound, and a drag that pulls the thread.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "turgor/window/viewer.hpp"

namespace turgor {

namespace {

using Clock = std::chrono::steady_clock;

constexpr double kShortestStitch = 0.003;  // between its points [m]
constexpr double kPullDuration = 0.1;      // of a pull while dragging [s]

/// Point on the skin of a body in the CT; empty on the wall of a wound.
std::optional<SkinPoint> skin_point(const Viewer& viewer, const Picked& picked) {
  const BodySnapshot& body = viewer.now->snapshot.bodies[picked.body];
  const bool is_wall = body.wall_begin > 0 && picked.triangle >= body.wall_begin;
  const std::optional<Vec3d> rest = rest_point(viewer.now->snapshot, picked);
  if (is_wall || !rest) return std::nullopt;
  const Int3 t = body.triangles[picked.triangle];
  const Vec3d a(body.rest[std::size_t(t.x)]), b(body.rest[std::size_t(t.y)]), c(body.rest[std::size_t(t.z)]);
  return SkinPoint{picked.point, picked.normal, *rest, normalized(cross(b - a, c - a))};
}

/// Lays the stitch that was drawn. The drag that may follow pulls it.
void request_stitch(Viewer& viewer, const DrawnStitch& stitch) {
  const StitchSettings& settings = viewer.stitches;
  const double length = norm(stitch.to->rest - stitch.from.rest);
  if (length < kShortestStitch) {
    viewer.message = viewer.failure = "no stitch: expected points 3 mm apart or more";
    return;
  }
  const auto below = [&settings](const SkinPoint& p) { return p.rest - p.rest_outward * settings.depth; };
  StitchRequest request{.body = viewer.now->snapshot.bodies[stitch.body].id.index};
  request.through = {stitch.from.rest, below(stitch.from), below(*stitch.to), stitch.to->rest};
  request.thread = settings.thread;
  if (!settings.until_closed) request.tension = settings.tension;
  viewer.session.request(request);
  viewer.touched = (stitch.from.now + stitch.to->now) * 0.5;
  viewer.pulled = PulledStitch{.number = viewer.now->stitches.size(), .cursor = viewer.cursor.y};
  viewer.stitches.selected = -1;
  viewer.message = fmt::format("a stitch of {:.0f} mm", 1e3 * length);
  if (!viewer.now->plays) viewer.message += ": Play pulls it";
}

/// Sets the tension from the height of the cursor, a few times per second or at the end of the drag.
void pull(Viewer& viewer, bool ends) {
  constexpr double kNewtons = 4;  // over half the picture
  constexpr double kDead = 0.02;  // a click moves the cursor less, over half the picture
  constexpr auto kPause = std::chrono::milliseconds(60);
  PulledStitch& pulled = *viewer.pulled;
  if (pulled.number >= viewer.now->stitches.size()) return;  // not laid yet, or refused
  const double moved = viewer.cursor.y - pulled.cursor;
  if (!pulled.tension && std::abs(moved) < kDead) return;
  const HandStitch& stitch = viewer.now->stitches[pulled.number];
  if (!pulled.tension) pulled.tension = stitch.request.tension.value_or(stitch.tension);
  const double goal = std::clamp(*pulled.tension + kNewtons * moved, kLeastTension, kMostTension);
  const bool is_due = ends || Clock::now() > pulled.requested + kPause;
  if (!is_due || (pulled.goal && std::abs(goal - *pulled.goal) < 0.01)) return;
  viewer.session.request(TightenRequest{.suture = stitch.suture,
                                        .tension = goal,
                                        .duration = kPullDuration,
                                        .continues = pulled.goal.has_value()});
  pulled.goal = goal, pulled.requested = Clock::now();
  viewer.stitches.tension = goal, viewer.stitches.until_closed = false;
  viewer.message = fmt::format("pulled to {:.2f} N", goal);
}

}  // namespace

bool press_stitch(Viewer& viewer, const Picked& picked) {
  if (viewer.now->snapshot.bodies[picked.body].id.kind != BodyKind::kLattice) return false;
  const std::optional<SkinPoint> point = skin_point(viewer, picked);
  if (!point) {
    viewer.message = viewer.failure = "no point: expected skin beside the wound";
    return true;
  }
  if (!viewer.stitch || viewer.stitch->body != picked.body) {
    viewer.stitch = DrawnStitch{.body = picked.body, .from = *point, .to = {}};
    viewer.message = "now the point on the other side of the wound";
    return true;
  }
  DrawnStitch stitch = *viewer.stitch;
  stitch.to = point;
  viewer.stitch.reset();
  request_stitch(viewer, stitch);
  return true;
}

void move_stitch(Viewer& viewer) {
  if (viewer.pulled) return pull(viewer, false);
  if (!viewer.stitch || viewer.camera_button) return;
  const auto picked = pick(viewer.now->snapshot, sight_ray(viewer.camera, viewer.cursor, viewer.aspect));
  viewer.stitch->to =
      picked && picked->body == viewer.stitch->body ? skin_point(viewer, *picked) : std::nullopt;
}

void release_stitch(Viewer& viewer) {
  if (!viewer.pulled) return;
  pull(viewer, true);
  viewer.pulled.reset();
}

const HandStitch* selected_stitch(const Viewer& viewer) {
  const std::vector<HandStitch>& stitches = viewer.now->stitches;
  if (stitches.empty()) return nullptr;
  const auto n = std::size_t(viewer.stitches.selected);
  return viewer.stitches.selected >= 0 && n < stitches.size() ? &stitches[n] : &stitches.back();
}

void tighten(Viewer& viewer, const HandStitch& stitch, std::optional<double> tension) {
  viewer.session.request(TightenRequest{.suture = stitch.suture, .tension = tension});
  viewer.message = tension ? fmt::format("pulled to {:.2f} N", *tension) : "pulled until the lips meet";
}

}  // namespace turgor

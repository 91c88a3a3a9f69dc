#include "turgor/sim/report/passed_surface.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "turgor/contact/tips.hpp"
#include "turgor/geometry/box.hpp"
#include "turgor/geometry/signed_distance.hpp"

namespace turgor {

namespace {

// Motion in a step, in radii of the tip, that all models resolve: 8 substeps of half a radius.
constexpr double kResolvedRadii = 4;
constexpr double kMostPoints = 2000;  // limit of sampled points of a step's path
constexpr int kMaxTips = 16;          // of a mesh tool

/// Surface of a body at rest.
struct RestBody {
  SignedDistance distance;
  double size = 0;  // diagonal of its box [m]
};
std::optional<RestBody> rest_body(const World& world, BodyId id) {
  const RestSurface rest = rest_surface(world, id);
  if (rest.triangles.empty() || id.kind == BodyKind::kCloth) return {};
  RestBody body{distance_to_surface(mesh_of(rest.vertices, rest.triangles)), 0};
  body.size = norm(body.distance.high - body.distance.low);
  return body;
}

/// True if the tool gets deeper on a straight path than at its start by more than its tip's radius.
bool goes_deeper(const RestBody& body, const contact::Shape& shape, const ForceSample& from,
                 const ForceSample& to) {
  const auto depth = [&](Vec3d position) {
    return contact::depth_in(body.distance, shape, {position, to.axes}, kMaxTips);
  };

  // points of the path
  const double limit = depth(from.position) + contact::tip_radius(shape);
  const double moved = norm(to.position - from.position);
  const int points = int(std::ceil(std::min(moved / contact::tip_radius(shape), kMostPoints)));
  for (int p = 1; p <= points; p++)
    if (depth(from.position + (to.position - from.position) * (double(p) / points)) > limit) return true;
  return false;
}

/// The test point of a tool that is lowest above the surface at rest.
struct LowestTip {
  Vec3d point;
  double height = std::numeric_limits<double>::infinity();  // negative inside [m]
};
LowestTip lowest_tip(const RestBody& body, const contact::Shape& shape, const ForceSample& sample) {
  LowestTip lowest;
  contact::visit_tips(shape, {sample.position, sample.axes}, kMaxTips, [&](Vec3d point, Vec3d) {
    if (const double height = body.distance.at(point); height < lowest.height) lowest = {point, height};
  });
  return lowest;
}

/// Direction away from the body at a point outside, unit.
Vec3d away_from(const RestBody& body, Vec3d point) {
  constexpr double kStep = 1e-5;  // [m]
  Vec3d away;
  for (int axis = 0; axis < 3; axis++) {
    Vec3d step;
    step[axis] = kStep;
    away[axis] = body.distance.at(point + step) - body.distance.at(point - step);
  }
  return normalized(away);
}

/// True if parts of a body cannot move: a tool that pushes the others cannot carry the body along.
bool has_fixed_parts(const World& world, BodyId id) {
  if (id.kind != BodyKind::kLattice) return id.kind != BodyKind::kRigid;
  const lattice::Anatomy& anatomy = world.lattice_bodies[std::size_t(id.index)].model.anatomy;
  return anatomy.free_nodes < anatomy.body_nodes;
}

/// Follows a tool through the body at rest. A tool has passed through if it left on the side opposite to that
/// of its entry and touches nothing there. A tool that bends a flap is on the other side too, in contact; but
/// no flap of a held body reaches farther than the body is long.
class Crossing {
 public:
  explicit Crossing(bool is_held) : is_held_(is_held) {}

  bool is_passed(const RestBody& body, const contact::Shape& shape, const ForceSample& sample) {
    const LowestTip tip = lowest_tip(body, shape, sample);
    const bool was_inside = std::exchange(inside_, tip.height < 0);
    if (inside_) is_opposite_ = false;
    if (inside_ && !was_inside && last_) entry_ = away_from(body, last_->point);
    if (was_inside && !inside_) is_opposite_ = entry_ && dot(*entry_, away_from(body, tip.point)) < 0;
    last_ = tip;
    return is_opposite_ && (sample.contacts == 0 || (is_held_ && tip.height > body.size));
  }

 private:
  bool is_held_ = false;
  bool inside_ = false, is_opposite_ = false;
  std::optional<LowestTip> last_;
  std::optional<Vec3d> entry_;  // away from the body where it entered
};

/// True for a sample at the pose that the scene commands. A hand's jump is a teleport, which moves nothing.
/// Tools that a host program moves have no path.
bool is_commanded(const TouchingTool& tool, const ForceSample& sample) {
  if (tool.hand.empty() && tool.path.rows.empty()) return false;
  return norm(command_at(tool, sample.time).pose.position - sample.position) < 1e-9;
}

}  // namespace

std::optional<SurfacePassage> surface_passage(const World& world, const TouchingTool& tool) {
  if (tool.tool.needle) return {};  // goes below the surface
  // jumps of the path that the models do not resolve
  const double far = kResolvedRadii * contact::tip_radius(tool.tool.shape);
  std::optional<RestBody> body;
  // the tip was within the body at rest at all
  const bool is_deep = std::any_of(tool.samples.begin(), tool.samples.end(), [&](const ForceSample& sample) {
    return sample.depth > contact::tip_radius(tool.tool.shape);
  });
  if (is_deep) body = rest_body(world, tool.body);
  Crossing crossing(has_fixed_parts(world, tool.body));
  const ForceSample* before = &tool.samples.start();
  for (const ForceSample& now : tool.samples) {
    const ForceSample& last = *std::exchange(before, &now);
    const SurfacePassage step{now.time, norm(now.position - last.position), now.time - last.time};
    if (tool.limits.passed_at && *tool.limits.passed_at < now.time) break;
    const bool passed = is_deep && body && crossing.is_passed(*body, tool.tool.shape, now);
    if (passed && is_commanded(tool, now) && !(step.moved > far)) return SurfacePassage{now.time, 0, 0};
    if (!(step.moved > far) || !is_commanded(tool, last) || !is_commanded(tool, now)) continue;
    if (!body && !(body = rest_body(world, tool.body))) break;
    // jumps out of or into contact, through the body, or farther than its size
    if (last.contacts > 0 || now.contacts > 0 || step.moved > body->size ||
        goes_deeper(*body, tool.tool.shape, last, now))
      return step;
  }

  // passages between the samples of the surface, found within the run
  if (!tool.limits.passed_at) return {};
  return SurfacePassage{*tool.limits.passed_at, 0, 0};
}

std::string passed_surface_note(const World& world, const TouchingTool& tool) {
  const std::optional<SurfacePassage> passage = surface_passage(world, tool);
  if (!passage) return {};
  const std::string& body = touched_body(world, tool.body).name;
  if (passage->moved > 0)
    return fmt::format(
        "{}: it moved {:.4g} mm within {:.3g} ms at {:.3f} s, farther than its contact with {} resolves: it "
        "passed through the surface or lost contact, and its forces from then on are not valid; a slower "
        "tool or a higher frame rate resolves its motion",
        tool.name, 1e3 * passage->moved, 1e3 * passage->within, passage->time, body);
  return fmt::format(
      "{}: it passed through the surface of {} at {:.3f} s: its forces from then on are not valid; a slower "
      "or wider tool, a smaller depth or a finer mesh keeps its contact",
      tool.name, body, passage->time);
}

}  // namespace turgor

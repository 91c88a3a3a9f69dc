// Contact of the walls of a wound, and the closure that has it.
#include "turgor/models/lattice/suture/wall_contact.hpp"

#include <algorithm>
#include <iterator>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/mechanics/skin_calibration.hpp"

namespace turgor::lattice {

namespace {

/// Stiffness of walls and rims of a closed wound that rests, over that of the tissue and skin around. Such
/// bodies come to rest with 3, 5 and 10; with 30, the sweeps of a step do not converge (PassiveClosure).
constexpr double kWallStiffness = 5;

bool is_wall(const WallPair& pair) { return pair.stitch < 0; }
bool has_walls(const WoundClosure& closure) {
  return std::any_of(closure.walls.begin(), closure.walls.end(), is_wall);
}
bool has_pressure(const WoundClosure& closure) {
  return std::any_of(closure.walls.begin(), closure.walls.end(), [](const WallPair& pair) {
    return is_wall(pair) && (pair.force > 0 || pair.multiplier > 0);
  });
}

/// Closure that has the walls of a wound: of those that were laid, the one whose walls bore before. Null:
/// none.
WoundClosure* closure_with_walls(std::span<WoundClosure* const> of_wound) {
  WoundClosure* found = nullptr;
  const auto rank = [](const WoundClosure& closure) { return 2 * has_pressure(closure) + bears(closure); };
  for (WoundClosure* closure : of_wound)
    if (has_walls(*closure) && (!found || rank(*closure) > rank(*found))) found = closure;
  return found;
}

/// Moves walls to another closure of the wound, where they go on with their forces N. It follows multipliers
/// until it rests again: λ = N + κ gap.
void hand_over(const Model& model, const Motion& motion, WoundClosure& from, WoundClosure& to) {
  remove_walls(to);
  std::vector<WallPair> walls;
  std::copy_if(from.walls.begin(), from.walls.end(), std::back_inserter(walls), is_wall);
  for (WallPair& pair : walls)
    pair.multiplier =
        pair.at.parted && pair.force > 0
            ? std::max(0.0, pair.force + wall_stiffness(model, pair, false) * gap_of(pair, motion))
            : 0;
  remove_walls(from);
  to.walls.insert(to.walls.begin(), walls.begin(), walls.end());
  to.settled = false;
}

}  // namespace

double penalty_at(const Model& model, const EmbeddedPoint& point) {
  const double young = double(model.anatomy.cell_young[std::size_t(point.cell)]),
               spacing = double(model.anatomy.lattice.spacing.x);
  return std::max(young, model.params.tissue.fat) * spacing +
         (model.params.skin.enabled ? skin_stiffness(model.params.skin) : 0);
}

double wall_stiffness(const Model& model, const WallPair& pair, bool is_settled) {
  return (is_settled ? kWallStiffness : 1) * penalty_at(model, pair.at.left);
}

double gap_of(const WallPair& pair, const Motion& motion) {
  return pair.gap +
         dot(Vec3d(displacement(pair.at.right, motion)) - Vec3d(displacement(pair.at.left, motion)),
             pair.normal);
}

PointStiffness outer(Vec3d g, double k) {
  const double size = norm(g);
  return axial_stiffness(Vec3(normalized(g)), Real(k * size * size), 0);
}

void update_wall(const Model& model, const Motion& motion, bool is_settled, WallPair& pair,
                 std::span<PointSpring> springs) {
  const double penalty = wall_stiffness(model, pair, is_settled);
  pair.force = std::max(0.0, pair.multiplier - penalty * gap_of(pair, motion));
  const PointStiffness stiffness = outer(pair.normal, pair.force > 0 ? 2 * penalty : 0);
  springs[0].force = Vec3(pair.normal * -pair.force), springs[1].force = Vec3(pair.normal * pair.force);
  springs[0].target = displacement(pair.at.left, motion);
  springs[1].target = displacement(pair.at.right, motion);
  springs[0].stiffness = springs[1].stiffness = stiffness;
  springs[0].coupling.stiffness = pair.force > 0 ? Real(penalty) : 0;
}

double wall_force(const WoundClosure& closure) {
  double sum = 0;
  if (!bears(closure)) return sum;
  for (const WallPair& pair : closure.walls)
    if (is_wall(pair)) sum += pair.force;
  return sum;
}

void remove_walls(WoundClosure& closure) { std::erase_if(closure.walls, is_wall); }

void share_walls(const Model& model, const Motion& motion, std::span<WoundClosure* const> of_wound) {
  WoundClosure* owner = closure_with_walls(of_wound);
  if (!owner) return;
  for (WoundClosure* closure : of_wound)
    if (closure != owner) remove_walls(*closure);
  if (bears(*owner)) return;
  // another one bears, or the wound is open
  const auto next = std::find_if(of_wound.begin(), of_wound.end(),
                                 [](const WoundClosure* closure) { return bears(*closure); });
  if (next != of_wound.end()) return hand_over(model, motion, *owner, **next);
  for (WallPair& pair : owner->walls) pair.force = pair.multiplier = 0;
}

}  // namespace turgor::lattice

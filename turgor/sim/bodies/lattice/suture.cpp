#include "turgor/sim/bodies/lattice/suture.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"

namespace turgor {

namespace {

lattice::StitchLayout layout_of(const SutureScene& scene, const lattice::Model& model) {
  lattice::StitchLayout layout{
      .spacing = scene.spacing, .bite = scene.bite, .depth = scene.depth, .is_running = scene.is_running};
  if (!scene.through.empty()) layout.through.push_back(points_of_stitch(scene, model));
  return layout;
}

Result<lattice::WoundClosure> lay(const Suture& suture, const LatticeBody& body,
                                  const lattice::BladePath& path) {
  Result<lattice::WoundClosure> closure =
      lattice::lay_stitches(body.model, body.state.cuts(), path, layout_of(suture.scene, body.model));
  if (!closure) return Error{fmt::format("{}: {}", suture.scene.source_location, closure.error().message)};
  closure->thread = suture.scene.thread, closure->pull_out = suture.scene.pull_out;
  return closure;
}

/// Unit vector from the middle of a stitch to its first and last point, lattice frame; zero for two points.
Vec3d outward_of(const lattice::Stitch& stitch) {
  Vec3d middle;
  for (const Vec3d p : stitch.rest) middle += p / double(stitch.rest.size());
  const std::size_t last = stitch.rest.size() - (stitch.is_open ? 2 : 1);
  const Vec3d up = (stitch.rest.front() + stitch.rest[last]) / 2 - middle;
  return norm(up) > 1e-6 ? normalized(up) : Vec3d{};
}

/// Adds a straight tube between two points.
void add_tube(Vec3d from, Vec3d to, double radius, TriMesh& mesh) {
  constexpr int kAround = 8;
  const Vec3d z = normalized(to - from);
  const Vec3d x = normalized(cross(std::abs(z.x) < 0.9 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}, z)),
              y = cross(z, x);
  const int first = int(mesh.vertices.size());
  for (const Vec3d end : {from, to})
    for (int a = 0; a < kAround; a++) {
      const double angle = 2 * std::numbers::pi * a / kAround;
      mesh.vertices.push_back(Vec3(end + (x * std::cos(angle) + y * std::sin(angle)) * radius));
    }
  for (int a = 0; a < kAround; a++) {
    const int b = first + (a + 1) % kAround, c = first + a;
    mesh.triangles.push_back({c, b, b + kAround});
    mesh.triangles.push_back({c, b + kAround, c + kAround});
  }
}

/// Error if a single stitch does not cross its wound.
Status check_crossing(const SutureScene& scene, const LatticeBody& body, const Cut& cut,
                      const lattice::BladePath& path) {
  if (scene.through.empty() || distance_of_stitch(scene, body.model, path)) return Done{};
  return Error{fmt::format("{}: through: expected points on both sides of the wound {}, found none near it",
                           scene.source_location, cut.blade.name)};
}

/// True if the other suture was laid on the wound of this one.
bool is_beside(const Suture& other, const Suture& suture) {
  return other.closure && other.scene.body == suture.scene.body &&
         other.scene.incision == suture.scene.incision;
}

}  // namespace

std::vector<Vec3d> points_of_stitch(const SutureScene& scene, const lattice::Model& model) {
  const Mat3d to_lattice = inverse(model.anatomy.grid.axes);
  std::vector<Vec3d> points;
  for (const Vec3d p : scene.through) points.push_back(to_lattice * (p - model.anatomy.grid.origin));
  return points;
}

std::optional<double> distance_of_stitch(const SutureScene& scene, const lattice::Model& model,
                                         const lattice::BladePath& path) {
  const std::vector<Vec3d> points = points_of_stitch(scene, model);
  double extent = 0;
  for (const Vec3d p : points) extent = std::max(extent, norm(p - points.front()));
  const std::optional<double> distance = distance_to_wound(path, points);
  return distance && *distance <= extent ? distance : std::nullopt;
}

Result<Suture> suture_of_wound(const SutureScene& scene, const LatticeBody& body, const Cut& cut) {
  TURGOR_ASSERT(cut.path && cut.done >= 1, "the wound is cut");
  Suture suture{.scene = scene};
  if (const Status crosses = check_crossing(scene, body, cut, *cut.path); !crosses) return crosses.error();
  const Result<lattice::WoundClosure> trial = lay(suture, body, *cut.path);
  if (!trial) return trial.error();
  return suture;
}

Result<Suture> load_suture(const SutureScene& scene, const LatticeBody& body, const Cut& cut) {
  Suture suture{.scene = scene};
  // trial on the uncut body
  const Result<lattice::BladePath> path = lattice::lay_blade(body.model, body.state, cut.blade);
  if (!path) return Error{fmt::format("{}: {}", scene.source_location, path.error().message)};
  if (const Status crosses = check_crossing(scene, body, cut, *path); !crosses) return crosses.error();
  const Result<lattice::WoundClosure> trial = lay(suture, body, *path);
  if (!trial) return trial.error();
  double needed = 0;
  for (const lattice::Stitch& stitch : trial->stitches) needed += rest_length(stitch);
  if (scene.thread_length > 0 && scene.thread_length < needed)
    return Error{
        fmt::format("{}: thread_length: the thread is shorter than its stitches: expected at least "
                    "{:.3g} m for {} stitches, found {:.3g} m",
                    scene.source_location, needed, trial->stitches.size(), scene.thread_length)};
  return suture;
}

Status advance_suture(const LatticeBody& body, const Cut& cut, double time, Suture& suture) {
  if (time < suture.scene.pull.start || !cut.path || cut.done < 1) return Done{};
  if (!suture.closure) {
    Result<lattice::WoundClosure> closure = lay(suture, body, *cut.path);
    if (!closure) return closure.error();
    suture.closure = std::move(*closure);
  }
  lattice::WoundClosure& closure = *suture.closure;
  if (closure.version != cut_version(body.state.cuts()) &&
      !lattice::embed_closure(body.model, body.state.cuts(), closure))
    return Error{fmt::format("{}: a later cut removed the tissue of a stitch", suture.scene.source_location)};
  lattice::pull_stitches(body.state->motion, suture.scene.pull, time, closure);
  return Done{};
}

SutureSprings::SutureSprings(const LatticeBody& body, int index, std::span<Suture> sutures) {
  for (Suture& suture : sutures) {
    if (suture.scene.body != index || !suture.closure) continue;
    closures.push_back(&*suture.closure);
    of_wounds[suture.scene.incision].push_back(closures.back());
  }
  for (const auto& [wound, all] : of_wounds) share_walls(body.model, body.state->motion, all);
  for (const lattice::WoundClosure* closure : closures) append_springs(*closure, springs.all);
  if (springs.all.empty()) return;
  make_terms(springs);
  springs.settled = std::all_of(closures.begin(), closures.end(),
                                [](const lattice::WoundClosure* closure) { return closure->settled; });
  springs.refresh = [this, &model = body.model](const lattice::State& state) {
    std::size_t next = 0;
    for (lattice::WoundClosure* closure : closures) {
      const std::size_t count = spring_count(*closure);
      update_springs(model, state.motion, *closure, std::span(springs.all).subspan(next, count));
      next += count;
    }
  };
}

void SutureSprings::finish(const lattice::Model& model, const lattice::Motion& motion, double time) {
  for (lattice::WoundClosure* closure : closures) {
    update_multipliers(model, motion, *closure);
    end_overloaded_stitches(motion, time, *closure);
  }
  for (const auto& [wound, all] : of_wounds) share_walls(model, motion, all);
}

void remove_suture(const LatticeBody& body, std::size_t number, std::vector<Suture>& sutures) {
  Suture& removed = sutures[number];
  if (removed.closure) {
    // walls go to another suture once none of its stitches bears
    for (lattice::Stitch& stitch : removed.closure->stitches) stitch.phase = lattice::StitchPhase::kBroken;
    std::vector<lattice::WoundClosure*> of_wound;
    for (Suture& other : sutures)
      if (is_beside(other, removed)) of_wound.push_back(&*other.closure);
    share_walls(body.model, body.state->motion, of_wound);
  }
  sutures.erase(sutures.begin() + std::ptrdiff_t(number));
}

double closing_force(const LatticeBody& body, const Suture& suture, std::span<const Suture> sutures) {
  if (!suture.closure) return 0;
  double of_threads = 0, of_walls = 0;
  for (const Suture& other : sutures)
    if (is_beside(other, suture))
      of_threads += thread_force(*other.closure, body.state->motion), of_walls += wall_force(*other.closure);
  const double own = thread_force(*suture.closure, body.state->motion);
  return own - (of_threads > 0 ? own / of_threads * of_walls : 0);
}

TriMesh thread_mesh(const LatticeBody& body, const Suture& suture) {
  constexpr double kThinnest = 0.4e-3;  // drawn radius, so that pictures show thin threads [m]
  constexpr double kLift = 4e-3;        // of the drawn strand, so that skin that bulges does not hide it [m]
  TriMesh mesh;
  if (!suture.closure) return mesh;
  const Grid& grid = body.model.anatomy.grid;
  const double radius = std::max(kThinnest, suture.scene.diameter / 2);
  for (const lattice::Stitch& stitch : suture.closure->stitches) {
    if (!bears(stitch.phase)) continue;
    std::vector<Vec3d> points;
    for (std::size_t p = 0; p < stitch.rest.size(); p++)
      points.push_back(grid.origin +
                       grid.axes * (stitch.rest[p] + Vec3d(displacement(stitch.at[p], body.state->motion))));
    // the strand between the last point and the first one runs above the skin
    const Vec3d lift = grid.axes * outward_of(stitch) * kLift;
    const Vec3d goal = stitch.is_open ? points.back() : points.front();
    if (stitch.is_open) points.pop_back();
    points.insert(points.end(), {points.back() + lift, goal + lift, goal});
    for (std::size_t p = 1; p < points.size(); p++) add_tube(points[p - 1], points[p], radius, mesh);
  }
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

}  // namespace turgor

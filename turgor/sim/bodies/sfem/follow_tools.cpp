#include "turgor/sim/bodies/sfem/follow_tools.hpp"

#include <algorithm>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/models/sfem/green.hpp"
#include "turgor/sim/bodies/sfem/choose_patch.hpp"

namespace turgor {

void reject_patch(SfemBody& body, const Error& why) {
  if (body.rejected_patches++ == 0) body.rejection_reason = why.message;
}

void retain_patch(std::vector<std::shared_ptr<const sfem::Patch>>& patches,
                  const std::shared_ptr<const sfem::Patch>& patch) {
  std::erase_if(patches, [](const auto& kept) { return kept.use_count() == 1; });
  patches.push_back(patch);
}

void restore_nonlinear(SfemBody& body, const sfem::Patch& patch) {
  if (body.nonlinear) return;
  Result<sfem::NonlinearPatch> made =
      sfem::make_nonlinear_patch(body.model, patch, body.refinement, *body.law);
  TURGOR_ASSERT(bool(made), "a nonlinear patch that was made before is made again");
  if (made->u.size() == body.law_displacement.size()) made->u = body.law_displacement;
  body.nonlinear = std::make_unique<sfem::NonlinearPatch>(std::move(*made));
}

namespace {

/// These vertices, those of the patches in use, and those that bear force now; ascending.
std::vector<int> vertices_in_use(const SfemBody& body, std::vector<int> vertices) {
  for (const auto& patch : body.patches)
    vertices.insert(vertices.end(), patch->coarse.begin(), patch->coarse.end());
  if (body.now.patch != nullptr)
    for (const contact::VertexForce& force : coarse_forces_now(body)) vertices.push_back(force.vertex);
  sort_unique(vertices);
  return vertices;
}

/// Fetches Green's function columns for the next patches, with a store on demand. Error: together with the
/// patch they exceed the memory limit.
Status fetch_columns_near(const Exec& exec, SfemBody& body, std::span<const Vec3d> positions) {
  if (!body.facts.on_demand) return Done{};
  // memory of the columns and of the patch
  const auto [bytes, vertices] = needs_of_patch(body, positions);
  if (bytes > double(body.patch_memory))
    return Error{
        fmt::format("a patch with the columns of Green's functions that it needs would take {:.3g} GB, "
                    "the limit is {:.3g} GB: use a smaller patch.radius, a lower patch.refinement or more "
                    "memory",
                    bytes * 1e-9, double(body.patch_memory) * 1e-9)};

  // fetch; where columns of earlier patches would exceed the limit, forget them
  if (const double held = double(sfem::column_bytes(body.model.green));
      held + bytes > double(body.patch_memory))
    sfem::keep_columns(body.model.green, vertices_in_use(body, vertices));
  sfem::fetch_columns(exec, body.model, vertices);
  return Done{};
}

/// Forces on points, on the points of another patch that are the same.
std::vector<double> same_forces(const sfem::Patch& from, std::span<const Vec3d> forces,
                                const sfem::Patch& to) {
  std::vector<std::pair<std::uint64_t, int>> by_key;
  for (std::size_t i = 0; i < from.points.size(); i++) by_key.emplace_back(from.points[i].key, int(i));
  std::sort(by_key.begin(), by_key.end());
  std::vector<double> moved;
  for (const sfem::PatchPoint& point : to.points) {
    const auto found = std::lower_bound(by_key.begin(), by_key.end(), std::pair(point.key, 0));
    const bool is_same = found != by_key.end() && found->first == point.key;
    const Vec3d f = is_same ? forces[std::size_t(found->second)] : Vec3d{};
    moved.insert(moved.end(), {f.x, f.y, f.z});
  }
  return moved;
}

/// Contact forces on the points of a patch, at a stiffness_scale of 1.
struct PointForces {
  std::shared_ptr<const sfem::Patch> patch;  // null: none
  std::vector<Vec3d> force;                  // [N]
};

BuiltPatch solve_new_patch(const SfemBody& body, const sfem::Law& law, const sfem::Patch& linear,
                           const PointForces& forces, const Timer& timer) {
  constexpr int kMostSteps = 12;
  Result<sfem::NonlinearPatch> made = sfem::make_nonlinear_patch(body.model, linear, body.refinement, law);
  if (!made) return {made.error(), timer.seconds()};
  auto nonlinear = std::make_shared<sfem::NonlinearPatch>(std::move(*made));
  const std::vector<double> f = forces.patch ? same_forces(*forces.patch, forces.force, nonlinear->patch)
                                             : std::vector<double>(3 * nonlinear->patch.points.size());
  sfem::NonlinearReport report;
  Result<sfem::Patch> solved = sfem::solve_nonlinear(*nonlinear, f, kMostSteps, &report);
  if (!solved) return {solved.error(), timer.seconds()};
  return {std::make_shared<const sfem::Patch>(std::move(*solved)), timer.seconds(), nonlinear, report};
}

/// `law` is that of the body, which frames may change meanwhile.
BuiltPatch build_patch_at(const SfemBody& body, const std::optional<sfem::Law>& law,
                          const std::vector<Vec3d>& positions, const PointForces& forces) {
  const Timer timer;
  const std::vector<int> elements = elements_of_patch(body, positions, body.follow.radius);
  Result<sfem::Patch> patch =
      sfem::build_patch(body.model, elements, body.refinement, positions, body.patch_memory);
  if (!patch) return {patch.error(), timer.seconds()};
  if (law) return solve_new_patch(body, *law, *patch, forces, timer);
  auto shared = std::make_shared<const sfem::Patch>(std::move(*patch));
  return {std::move(shared), timer.seconds()};
}

/// Fetches columns, then starts building a patch concurrently. False: the columns exceed the memory limit.
bool begin_patch(const Exec& exec, SfemBody& body, const std::vector<Vec3d>& positions, PointForces forces) {
  if (const Status status = fetch_columns_near(exec, body, positions); !status) {
    reject_patch(body, status.error());
    return false;
  }
  if (!body.worker) body.worker = std::make_unique<PatchWorker>();
  // reads only data of the body that no tick and no frame changes
  body.worker->begin([&body, law = body.law, positions, forces = std::move(forces)] {
    return build_patch_at(body, law, positions, forces);
  });
  return true;
}

bool has_solver(const SfemBody& body) { return body.haptic && body.haptic->solver; }

/// Starts solving the nonlinear patch for these forces. False where nothing has changed, or where it is
/// solved beside the ticks.
bool begin_solution(SfemBody& body, const PointForces& now) {
  if (!body.law || has_solver(body) || now.force == body.law_forces ||
      (body.worker && body.worker->is_busy()))
    return false;
  restore_nonlinear(body, *now.patch);
  body.nonlinear->law = *body.law;
  body.law_forces = now.force;
  std::vector<double> forces;
  for (const Vec3d f : now.force) forces.insert(forces.end(), {f.x, f.y, f.z});
  if (!body.worker) body.worker = std::make_unique<PatchWorker>();
  body.worker->begin([&body, forces = std::move(forces)]() -> BuiltPatch {
    const Timer timer;
    sfem::NonlinearReport report;
    Result<sfem::Patch> solved = sfem::solve_nonlinear(*body.nonlinear, forces, kLawSteps, &report);
    if (!solved) return {solved.error(), timer.seconds()};
    return {std::make_shared<const sfem::Patch>(std::move(*solved)), timer.seconds(), {}, report};
  });
  return true;
}

/// Takes the nonlinear patch and the statistics of a finished solution.
void keep_solution(SfemBody& body, const BuiltPatch& built) {
  if (built.nonlinear) {
    body.nonlinear = std::make_unique<sfem::NonlinearPatch>(*built.nonlinear);
    body.law_forces.clear();
  }
  if (!built.law) return;
  add_solution(body.law_summary, *built.law, built.nonlinear ? 0 : built.seconds);
}

PatchRebuild rebuild_of(const BuiltPatch& built, double time) {
  const sfem::Patch& patch = **built.patch;
  return {.time = time,
          .seconds = built.seconds,
          .elements = int(patch.elements.size()),
          .local_nodes = patch.local_nodes,
          .points = int(patch.points.size()),
          .is_solution = built.law && !built.nonlinear};
}

/// Positions that patches follow, of tools with these poses.
std::vector<Vec3d> touched_positions(const SfemBody& body, std::span<const contact::ContactCenter> centers,
                                     std::vector<contact::ToolPose> poses) {
  for (std::size_t t = 0; t < poses.size(); t++)
    poses[t].pose.position = contact::tool_position(body.touch.tools[t].shape, poses[t].pose);
  return contact::touched_positions(body.model, centers, poses, body.centers);
}
}  // namespace

Result<std::shared_ptr<const sfem::Patch>> first_patch(const Exec& exec, SfemBody& body) {
  if (const Status status = fetch_columns_near(exec, body, body.centers); !status) return status.error();
  BuiltPatch built = build_patch_at(body, body.law, body.centers, {});
  if (built.patch) retain_patch(body.patches, *built.patch), keep_solution(body, built);
  return built.patch;
}

std::optional<NextPatch> follow_tools(const Exec& exec, SfemBody& body,
                                      std::span<const contact::ToolCommand> commands, long due) {
  std::vector<contact::ContactCenter> contact_centers(commands.size());
  contact::find_contact_centers(*body.touch.patch, body.touch.state, contact_centers);
  std::vector<contact::ToolPose> poses;
  for (const contact::ToolCommand& command : commands) poses.push_back({command.pose, command.hold});
  std::vector<Vec3d> positions = touched_positions(body, contact_centers, std::move(poses));
  if (!contact::must_follow(body.follow, body.centers, positions)) return {};
  PointForces now{body.touch.patch, body.touch.state.force};
  if (begin_patch(exec, body, positions, std::move(now))) return NextPatch{std::move(positions), due};
  body.centers = std::move(positions);
  return {};
}

std::optional<NextPatch> solve_law(SfemBody& body, long due) {
  if (due % kLawTicks != 0 || !begin_solution(body, {body.touch.patch, body.touch.state.force})) return {};
  return NextPatch{body.centers, due};
}

bool take_next_patch(SfemBody& body, NextPatch& next, double time) {
  // finished patch
  TURGOR_ASSERT(body.worker, "a patch is taken from the worker that builds it");
  const BuiltPatch built = body.worker->finish();
  body.centers = std::move(next.centers);
  if (!built.patch) {
    reject_patch(body, built.patch.error());
    return false;
  }
  const std::shared_ptr<const sfem::Patch>& patch = *built.patch;
  retain_patch(body.patches, patch);
  keep_solution(body, built);

  // exchange, with the contact history transferred
  PatchRebuild rebuild = rebuild_of(built, time);
  const Timer taking;
  const contact::FinishedPatch offer{.patch = patch,
                                     .history = contact::transferred_history(
                                         body.model, body.touch.state.history, *body.touch.patch, *patch),
                                     .number = long(body.rebuilds.size()) + 1};

  // cost
  rebuild.force_jump = contact::take_patch(body.touch, offer).force_jump;
  rebuild.handover_seconds = taking.seconds();
  body.rebuilds.push_back(rebuild);
  return true;
}

void offer_patch(const Exec& exec, SfemBody& body, double time, latest<contact::FinishedPatch>& offers) {
  const contact::SfemTouchSnapshot& now = body.now;

  // offer a finished patch
  if (body.worker && body.worker->is_busy()) {
    if (!body.patch_is_ready.value_or(body.worker->is_ready())) return;
    const BuiltPatch built = body.worker->finish();
    body.built_patches++;
    if (!built.patch) return reject_patch(body, built.patch.error());
    retain_patch(body.patches, *built.patch);
    keep_solution(body, built);
    body.rebuilds.push_back(rebuild_of(built, time));
    if (has_solver(body) && built.nonlinear)
      body.haptic->solver->add({*built.patch, *built.nonlinear, long(body.rebuilds.size())});
    contact::FinishedPatch& offer = offers.writing();
    offer.patch = *built.patch;
    offer.history = contact::transferred_history(body.model, now.history, *now.patch, **built.patch);
    offer.number = long(body.rebuilds.size());
    offers.publish();
    // the next solution at the same points may begin
    if (body.rebuilds.back().is_solution) (void)begin_solution(body, {now.patch, now.force});
    return;
  }
  if (now.patch_number < long(body.rebuilds.size()))
    return;  // the haptic thread has not taken the previous patch yet

  // start the next one
  std::vector<Vec3d> positions = touched_positions(body, now.contact_centers, now.poses);
  if (!contact::must_follow(body.follow, body.centers, positions)) {
    (void)begin_solution(body, {now.patch, now.force});
    return;
  }
  (void)begin_patch(exec, body, positions, {now.patch, now.force});
  body.centers = std::move(positions);
}

}  // namespace turgor

#include "turgor/sim/bodies/sfem/follow_tools.hpp"

#include <memory>
#include <utility>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/models/sfem/green.hpp"
#include "turgor/sim/bodies/sfem/choose_patch.hpp"

namespace turgor {

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

/// Keeps the present patch and counts the rejection.
void reject_patch(SfemBody& body, const Error& why) {
  if (body.rejected_patches++ == 0) body.rejection_reason = why.message;
}

BuiltPatch build_patch_at(const SfemBody& body, const std::vector<Vec3d>& positions) {
  const Timer timer;
  const std::vector<int> elements = elements_of_patch(body, positions, body.follow.radius);
  Result<sfem::Patch> patch =
      sfem::build_patch(body.model, elements, body.refinement, positions, body.patch_memory);
  if (!patch) return {patch.error(), timer.seconds()};
  auto shared = std::make_shared<const sfem::Patch>(std::move(*patch));
  return {std::move(shared), timer.seconds()};
}

/// Fetches columns, then starts building a patch concurrently. False: the columns exceed the memory limit.
bool begin_patch(const Exec& exec, SfemBody& body, const std::vector<Vec3d>& positions) {
  if (const Status status = fetch_columns_near(exec, body, positions); !status) {
    reject_patch(body, status.error());
    return false;
  }
  if (!body.worker) body.worker = std::make_unique<PatchWorker>();
  // reads only data of the body that no tick and no frame changes
  body.worker->begin([&body, positions] { return build_patch_at(body, positions); });
  return true;
}

PatchRebuild rebuild_of(const sfem::Patch& patch, double time, double seconds) {
  return {.time = time,
          .seconds = seconds,
          .elements = int(patch.elements.size()),
          .local_nodes = patch.local_nodes,
          .points = int(patch.points.size())};
}

/// Releases patches that are no longer in use; their destruction must not happen on the haptic thread.
void retain_patch(std::vector<std::shared_ptr<const sfem::Patch>>& patches,
                  const std::shared_ptr<const sfem::Patch>& patch) {
  std::erase_if(patches, [](const auto& kept) { return kept.use_count() == 1; });
  patches.push_back(patch);
}

}  // namespace

Result<std::shared_ptr<const sfem::Patch>> first_patch(const Exec& exec, SfemBody& body) {
  if (const Status status = fetch_columns_near(exec, body, body.centers); !status) return status.error();
  BuiltPatch built = build_patch_at(body, body.centers);
  if (built.patch) retain_patch(body.patches, *built.patch);
  return built.patch;
}

std::optional<NextPatch> follow_tools(const Exec& exec, SfemBody& body,
                                      std::span<const contact::ToolCommand> commands, long due) {
  std::vector<contact::ContactCenter> contact_centers(commands.size());
  contact::find_contact_centers(*body.touch.patch, body.touch.state, contact_centers);
  std::vector<contact::ToolPose> poses;
  for (const contact::ToolCommand& command : commands) poses.push_back({command.pose, command.hold});
  std::vector<Vec3d> positions = contact::touched_positions(body.model, contact_centers, poses, body.centers);
  if (!contact::must_follow(body.follow, body.centers, positions)) return {};
  if (begin_patch(exec, body, positions)) return NextPatch{std::move(positions), due};
  body.centers = std::move(positions);
  return {};
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

  // exchange, with the contact history transferred
  PatchRebuild rebuild = rebuild_of(*patch, time, built.seconds);
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
    body.rebuilds.push_back(rebuild_of(**built.patch, time, built.seconds));
    contact::FinishedPatch& offer = offers.writing();
    offer.patch = *built.patch;
    offer.history = contact::transferred_history(body.model, now.history, *now.patch, **built.patch);
    offer.number = long(body.rebuilds.size());
    offers.publish();
    return;
  }
  if (now.patch_number < long(body.rebuilds.size()))
    return;  // the haptic thread has not taken the previous patch yet

  // start the next one
  std::vector<Vec3d> positions =
      contact::touched_positions(body.model, now.contact_centers, now.poses, body.centers);
  if (!contact::must_follow(body.follow, body.centers, positions)) return;
  (void)begin_patch(exec, body, positions);
  body.centers = std::move(positions);
}

}  // namespace turgor

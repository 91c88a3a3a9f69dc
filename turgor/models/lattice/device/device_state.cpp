#include "turgor/models/lattice/device/device_state.hpp"

#include <algorithm>

#include "turgor/core/timing.hpp"
#include "turgor/models/lattice/coarse/coarse_correction.hpp"

namespace turgor::lattice {

namespace {

/// What is there is this state, as it is.
void put_over(const Model& model, const std::shared_ptr<MirroredState>& kept) {
  claim(kept);
  if (kept->changed == Changed::kAll) kept->there->put_state(model, kept->state);
  if (kept->changed == Changed::kPart) kept->there->put_cuts(model, kept->state);
  kept->changed = Changed::kNothing;
}

/// Are the state's numbers there as well, whether or not they came back?
bool is_allocated(const std::shared_ptr<MirroredState>& kept) {
  return kept->there->whose.lock() == kept && kept->changed == Changed::kNothing;
}

}  // namespace

std::size_t DeviceState::cuts() const { return cut_version(kept_->state); }

std::vector<int> DeviceState::places_in(std::span<const SurfaceSample> places, std::uint64_t version,
                                        std::span<const Ball> balls) const {
  if (!kept_->there) return lattice::places_in(places, kept_->state, balls);
  const std::lock_guard lock(kept_->there->in_use);
  return kept_->away ? kept_->there->find_places(places, version, balls)
                     : lattice::places_in(places, kept_->state, balls);
}

StepReport DeviceState::step(const Exec& exec, const Model& model, const Inputs& inputs, double dt) {
  if (!kept_->there) return lattice::step(exec, model, kept_->state, inputs, dt);
  const std::lock_guard lock(kept_->there->in_use);
  put_over(model, kept_);
  kept_->go();
  State& state = kept_->state;
  const bool smooth = prepare_coarse_space(model, state, inputs, dt);
  const StepReport report = kept_->there->step(model, state, smooth, inputs, dt);
  state.fastest = report.largest_speed;
  if (report.finite) state.time += dt;
  kept_->update_views();
  return report;
}

std::optional<DeviceResampled> DeviceState::resample_there(const Exec& exec, const Model& model,
                                                           const CtVolume& ct, const Grid& grid,
                                                           const ResampleOptions& options) const {
  if (!kept_->there) return {};
  const Timer timer;
  const std::lock_guard lock(kept_->there->in_use);
  if (!is_allocated(kept_)) return {};
  std::optional<DeviceResampled> now = kept_->there->resample(exec, model, kept_->state, ct, grid, options);
  if (now) now->report.seconds = timer.seconds();
  return now;
}

ResampledCt DeviceState::resample(const Exec& exec, const Model& model, const CtVolume& ct, const Grid& grid,
                                  const ResampleOptions& options) const {
  const Timer timer;
  const auto there = resample_there(exec, model, ct, grid, options);
  if (!there) return resample_ct(exec, model, here(), ct, grid, options);
  ResampledCt now{.ct = {.grid = there->grid, .samples = {}}, .report = there->report};
  now.ct.samples.resize(sample_count(grid));
  there->samples->get(now.ct.samples);
  now.report.seconds = timer.seconds();
  return now;
}

/// False: it is here, or there is no room there.
template <class Get>
bool DeviceState::get_from_there(const Get& get) const {
  if (!kept_->there) return false;
  const std::lock_guard lock(kept_->there->in_use);
  return is_allocated(kept_) && get(*kept_->there);
}

VectorVolume DeviceState::resample_displacement(const Exec& exec, const Model& model,
                                                const Grid& grid) const {
  VectorVolume field{.grid = grid, .samples = std::vector<Vec3>(sample_count(grid))};
  if (get_from_there([&](BodyBackend& there) {
        return there.get_displacement(model, kept_->state, grid, field.samples);
      }))
    return field;
  return lattice::resample_displacement(exec, model, here(), grid);
}

ScalarVolume DeviceState::resample_jacobian(const Exec& exec, const Model& model, const Grid& grid) const {
  ScalarVolume field{.grid = grid, .samples = std::vector<float>(sample_count(grid))};
  if (get_from_there(
          [&](BodyBackend& there) { return there.get_jacobian(model, kept_->state, grid, field.samples); }))
    return field;
  return lattice::resample_jacobian(exec, model, here(), grid);
}

template <class Cut>
int DeviceState::cut_with(State& state, const Cut& cut) {
  const std::size_t before = cut_version(state);
  const int count = cut(state);
  if (count > 0 || cut_version(state) != before) kept_->changed = std::max(kept_->changed, Changed::kPart);
  return count;
}

/// A state that is away stays there: copies of nodes come back, and the nodes where new ones are made; what
/// the blade changed goes over at once.
int DeviceState::cut_edges(const Model& model, const BladePath& path, double begin, double end,
                           int incision) {
  const auto cut = [&](const DownloadNodes& bring) {
    return cut_with(kept_->state, [&](State& state) {
      return lattice::cut_edges(model, state, path, begin, end, incision, bring);
    });
  };
  if (!kept_->there) return cut({});
  const std::lock_guard lock(kept_->there->in_use);
  if (!kept_->away) return cut({});
  const Borrowed some(*kept_, {}, true);
  const int count = cut([&](std::span<const int> nodes) { kept_->there->get_nodes(nodes, kept_->state); });
  put_over(model, kept_);
  return count;
}

int DeviceState::cut_region(const Model& model, const BladePath& path) {
  return cut_with(kept_->on_host(), [&](State& state) { return lattice::cut_region(model, state, path); });
}

}  // namespace turgor::lattice

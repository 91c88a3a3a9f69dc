// Body in device memory: a model, one state, and its steps. `Backend` provides arrays and a Run; it is
// GpuBackend (gpu_body.cu), and in tests the host with a shuffled order of threads. Data is transferred only
// by the methods named upload and download.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/models/lattice/device/device_coarse.hpp"
#include "turgor/models/lattice/device/device_nodes.hpp"
#include "turgor/models/lattice/device/device_pbd.hpp"
#include "turgor/models/lattice/device/device_readback.hpp"
#include "turgor/models/lattice/device/device_resampling.hpp"
#include "turgor/models/lattice/device/device_state.hpp"
#include "turgor/models/lattice/device/device_vbd.hpp"
#include "turgor/models/lattice/solver/step_sequence.hpp"

namespace turgor::lattice {

template <class Backend>
class DeviceBody final : public BodyBackend {
 public:
  DeviceBody(const Model& model, DeviceAllocator<Backend>& allocator, typename Backend::Run run = {})
      : run_(std::move(run)), nodes_(allocator, model) {
    TURGOR_ASSERT(model.anatomy.cell_laws.shear.empty(), "kernels step cells of one neo-Hookean law");
    if (model.params.solver.method == Method::kPbd)
      pbd_.emplace(allocator, pbd_ordering(model));
    else
      vbd_.emplace(allocator, model);
    if (supports_coarse_space(model)) coarse_.emplace(allocator, model);
  }

  void upload_state(const Model& model, const State& state) override {
    const Motion& motion = state.motion;
    nodes_.u.upload(motion.u), nodes_.u_before.upload(motion.u_before), nodes_.v.upload(motion.v);
    upload_cuts(model, state.cuts, state.cut_elements, motion.virtual_u, motion.virtual_u_before);
    TURGOR_CHECK(state.motion.u.x.size() == model.anatomy.inverse_mass.size(),
                 "positions are on the host before an upload");
  }
  void upload_cuts(const Model& model, const Cuts& cuts, const CutElements& elements,
                   std::span<const VirtualNodeDisplacement> virtual_u,
                   std::span<const VirtualNodeDisplacement> virtual_u_before) override {
    nodes_.upload_cuts(cuts);
    resampled_.forget_cuts();
    if (vbd_) vbd_->upload_cuts(model, cuts, elements, virtual_u, virtual_u_before);
  }
  void upload_prestress(const Model& model, const CutElements& elements) override {
    if (vbd_) vbd_->upload_element_nodes(model, elements);
  }
  void download_motion(Motion& motion) const override {
    nodes_.u.download(motion.u), nodes_.u_before.download(motion.u_before), nodes_.v.download(motion.v);
  }
  void download_state(State& state) const override {
    Motion& motion = state.motion;
    download_motion(motion);
    if (!vbd_) return;
    motion.virtual_u_before.resize(vbd_->shifts_before.count);
    download_virtual_nodes(motion);
    vbd_->shifts_before.array.download(motion.virtual_u_before);
  }

  void download_nodes(std::span<const int> slots, Motion& motion) override {
    readback_.download_nodes(run_, nodes_.view(), slots, motion);
  }
  void download_virtual_nodes(Motion& motion) const override {
    if (vbd_) vbd_->shifts.array.download(motion.virtual_u);
  }
  std::vector<int> find_samples(std::span<const SurfaceSample> samples, std::uint64_t version,
                                std::span<const Ball> balls) override {
    return readback_.find_samples(run_, nodes_.view().nodes, samples, version, balls);
  }

  StepReport step(const Model& model, const CutElements& elements,
                  const std::shared_ptr<const CoarseSpace>& coarse, Real fastest, const Inputs& inputs,
                  double dt) override {
    // step with an empty summary
    TURGOR_CHECK(is_step_length(dt), "a step has a positive length");
    upload_loads(inputs.loads);
    StepSummary summary;
    nodes_.summary.upload({&summary, 1});
    StepReport report =
        vbd_ ? step_vbd(model, elements, coarse, fastest, inputs, dt) : step_pbd(model, inputs, dt);
    nodes_.summary.download({&summary, 1});
    // finite: report the speed
    const Real speed2 = std::bit_cast<Real>(summary.largest);
    if (std::isfinite(speed2)) {
      report.largest_speed = std::sqrt(speed2);
      return report;
    }
    // not finite: restore the last state
    run_(std::size_t(nodes_.view().slots), RestoreSlot{nodes_.view()});
    if (vbd_) {
      const VbdView view = vbd_->view(model, nodes_, inputs, dt);
      run_(std::size_t(view.virtual_node_count), RestoreVirtualNode{view});
    }
    return {.finite = false};
  }

  std::optional<DeviceResampled> resample(const Exec& exec, const Model& model, const Cuts& cuts,
                                          const CtVolume& ct, const Grid& grid,
                                          const ResampleOptions& options) override {
    std::optional<DeviceResampled> now =
        resampled_.resample(run_, exec, model, cuts, to_resample(), ct, grid, options);
    if (!now) resampled_ = {};
    return now;
  }
  bool download_displacement(const Model& model, const Cuts& cuts, const Grid& grid,
                             std::span<Vec3> samples) override {
    return download_field(model, cuts, grid, DisplacementOfVoxel{model.anatomy.grid, grid}, samples);
  }
  bool download_jacobian(const Model& model, const Cuts& cuts, const Grid& grid,
                         std::span<float> samples) override {
    return download_field(model, cuts, grid, JacobianOfVoxel{}, samples);
  }

 private:
  BodyToResample to_resample() const {
    BodyToResample body{nodes_.view().nodes, nodes_.removed.data(), nullptr, 0};
    if (vbd_) body.shifts = vbd_->shifts.data(), body.shift_count = vbd_->shifts.count;
    return body;
  }
  template <class Of, class Sample>
  bool download_field(const Model& model, const Cuts& cuts, const Grid& grid, const Of& of,
                      std::span<Sample> samples) {
    const bool is_downloaded = resampled_.download_field(run_, model, cuts, to_resample(), grid, of, samples);
    if (!is_downloaded) resampled_ = {};
    return is_downloaded;
  }
  void upload_loads(std::span<const NodeLoad> loads) {
    TURGOR_CHECK(std::all_of(loads.begin(), loads.end(),
                             [&](const NodeLoad& l) { return is_index(l.slot, nodes_.w.size()); }),
                 "loads act on slots of the lattice");
    std::vector<NodeLoad> by_slot(loads.begin(), loads.end());
    std::stable_sort(by_slot.begin(), by_slot.end(),
                     [](const NodeLoad& a, const NodeLoad& b) { return a.slot < b.slot; });
    loads_.assign(by_slot);
  }

  NodeKernels<typename Backend::Run> node_kernels(const Model& model, double dt) const {
    return {run_, nodes_.view(), loads_.values(), dt, speed_scale(model.params.solver, dt)};
  }

  StepReport step_pbd(const Model& model, const Inputs& inputs, double dt) {
    TURGOR_ASSERT(inputs.contacts.empty(), "contacts need the VBD solver");
    run_together(run_, [&] {
      const PbdView view = pbd_->view(model, nodes_);
      lattice::step_pbd(
          PbdKernels<typename Backend::Run>{node_kernels(model, dt), view, lattice_gravity(model, inputs)},
          model.params.solver.sweeps);
    });
    return {};
  }

  StepReport step_vbd(const Model& model, const CutElements& elements,
                      const std::shared_ptr<const CoarseSpace>& coarse, Real fastest, const Inputs& inputs,
                      double dt) {
    // upload inputs
    TURGOR_CHECK(is_ascending(inputs.contacts, &NodeContact::slot), "the slots of contacts ascend");
    TURGOR_CHECK(!coarse || coarse_, "a coarse correction needs a coarse space");
    vbd_->update_prestress(model);
    if (coarse) coarse_->upload(model, elements, vbd_->shifts.count, coarse);
    vbd_->upload_contacts(model, inputs.contacts);
    VbdView view = vbd_->view(model, nodes_, inputs, dt);
    const auto sums = std::size_t(residuals_of_groups(view) + view.virtual_nodes_of_color.begin[kColorCount]);
    // partial residuals before and after the sweeps
    ResidualSum* before = nullptr;
    if (inputs.measure_residual) {
      vbd_->residual.resize(2 * sums);
      before = vbd_->residual.data(), view.residual = before + sums;
    }
    // relative speed of neighbors above which a held body starts the step from rest
    const Real speed_limit = largest_relative_speed(model, Real(dt));
    const bool held = model.anatomy.free_nodes < model.anatomy.body_nodes;
    // predictor, sweeps with coarse correction, velocities
    const auto correct = [&] {
      if (coarse)
        correct_two_grid(CorrectionKernels<typename Backend::Run>{run_, view, coarse_->view(model)});
    };
    run_together(run_, [&] {
      lattice::step_vbd(
          VbdKernels<typename Backend::Run, decltype(correct)>{
              node_kernels(model, dt), view, before, held,
              held && 2 * fastest > speed_limit ? speed_limit : 0, correct},
          model.params.tissue.law == TissueLaw::kSolid, vbd_sweeps(model.params));
    });
    // results
    StepReport report;
    if (inputs.measure_residual) report.residual = residual(model, sums);
    vbd_->contacts.array.download(inputs.contacts);
    return report;
  }

  /// Residual before and after the sweeps, from `count` partial sums each.
  Residual residual(const Model& model, std::size_t count) const {
    std::vector<ResidualSum> sums(2 * count);
    vbd_->residual.array.download(sums);
    ResidualSum all[2];
    for (std::size_t n = 0; n < sums.size(); n++) all[n / count].add(sums[n]);
    const int nodes = model.anatomy.free_nodes;
    return {.largest = all[1].largest(), .rms = all[1].rms(nodes), .before = all[0].rms(nodes)};
  }

  typename Backend::Run run_;
  DeviceNodes<Backend> nodes_;
  std::optional<DevicePbd<Backend>> pbd_;
  std::optional<DeviceVbd<Backend>> vbd_;
  std::optional<DeviceCoarse<Backend>> coarse_;
  DeviceList<Backend, NodeLoad> loads_;
  DeviceReadback<Backend> readback_;
  DeviceResampling<Backend> resampled_;
};

}  // namespace turgor::lattice

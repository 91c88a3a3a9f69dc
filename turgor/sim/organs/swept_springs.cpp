// Springs of attachments in the sweeps of a lattice (swept.hpp).
#include <algorithm>

#include "turgor/sim/organs/swept.hpp"
#include "turgor/sim/organs/swept_body.hpp"

namespace turgor {

namespace {

/// Force of a spring on its swept end, and its tangent, at a stretch.
lattice::PointSpring spring_at(const contact::Tie& tie, const lattice::EmbeddedPoint& at, Vec3d u,
                               Vec3d end) {
  lattice::PointSpring spring{.at = at, .target = Vec3(u)};
  const Vec3d stretch = u - end;
  const double size = norm(stretch), over = size - tie.slack;
  if (tie.broken || (tie.slack > 0 && over <= 0)) return spring;
  if (tie.slack == 0) {
    spring.target = Vec3(end), spring.stiffness = lattice::isotropic_stiffness(Real(tie.stiffness));
    return spring;
  }
  const Vec3d n = stretch / size;
  spring.force = Vec3(n * (-tie.stiffness * over));
  spring.stiffness =
      lattice::axial_stiffness(Vec3(n), Real(tie.stiffness), Real(tie.stiffness * over / size));
  return spring;
}

/// Point at a node.
lattice::EmbeddedPoint point_at(int slot) {
  lattice::EmbeddedPoint point;
  point.cell = slot, point.corner.fill(slot), point.weight[0] = 1;
  return point;
}

}  // namespace

SweptSprings::SweptSprings(const LatticeBody& body, World& world, lattice::PointSprings* stitches)
    : body_(body), stitches_(stitches) {
  if (stitches) springs_.all = stitches->all;
  for (Attachment& attachment : world.coupling.attachments) {
    if (attachment.swept < 0 || attachment.ahead.size() != attachment.ties.size()) continue;
    for (std::size_t n = 0; n < attachment.ties.size(); n++) {
      contact::Tie& tie = attachment.ties[n];
      const contact::SurfacePoint& own = attachment.swept == 0 ? tie.a : tie.b;
      if (tie.broken || !is_swept_by(world, body, own.body)) continue;
      const CoupledSupport& support = swept_support(world, own.body);
      const auto v = std::size_t(own.vertex.x);
      springs_.all.push_back({.at = support.cell.empty() ? point_at(support.carrier[v]) : support.cell[v]});
      ties_.push_back(&tie), signs_.push_back(attachment.swept == 0 ? 1 : -1);
      const Mat3d to_lattice = transposed(patient_axes(body));
      ends_.push_back(to_lattice * attachment.ahead[n]);
      before_.free_mass = support.free_mass;
      if (support.free_mass > 0)
        before_.add(to_lattice * tie.force * signs_.back(),
                    to_lattice * motion_ahead(world, attachment.swept == 0 ? tie.b : tie.a));
      if (attachments_.empty() || attachments_.back() != &attachment) attachments_.push_back(&attachment);
    }
  }
  if (ties_.empty()) return;
  make_terms(springs_);
  springs_.refresh = [this](const lattice::State& state) {
    if (stitches_ && stitches_->refresh) stitches_->refresh(state);
    refresh(state.motion);
  };
}

void SweptSprings::refresh(const lattice::Motion& motion) {
  const std::size_t first = springs_.all.size() - ties_.size();
  if (stitches_) std::copy(stitches_->all.begin(), stitches_->all.end(), springs_.all.begin());
  for (std::size_t n = 0; n < ties_.size(); n++) {
    lattice::PointSpring& spring = springs_.all[first + n];
    spring = spring_at(*ties_[n], spring.at, Vec3d(displacement(spring.at, motion)), ends_[n]);
  }
}

void SweptSprings::finish(const lattice::Motion& motion) {
  if (ties_.empty()) return;
  refresh(motion);
  const std::size_t first = springs_.all.size() - ties_.size();
  for (std::size_t n = 0; n < ties_.size(); n++) {
    const lattice::PointSpring& spring = springs_.all[first + n];
    const Vec3d force(spring_force(spring, displacement(spring.at, motion)));
    ties_[n]->force = patient_axes(body_) * (force * signs_[n]);
  }
  for (Attachment* attachment : attachments_) contact::break_overloaded(attachment->ties);
}

}  // namespace turgor

// Report of rigid bodies.
#include <cmath>
#include <numbers>

#include "turgor/sim/report/report.hpp"
#include "turgor/sim/report/section.hpp"

namespace turgor {

namespace {

using namespace units;

struct RigidShapeText {
  const char* operator()(const BoxSize&) const { return "box"; }
  const char* operator()(const BallTool&) const { return "sphere"; }
  const char* operator()(const RodTool&) const { return "capsule"; }
  const char* operator()(const SurfaceFile&) const { return "mesh"; }
};

struct RigidInput {
  const RigidScene& scene;
  const RigidBody& body;
};

Vec3d position_change(const RigidInput& r) { return r.body.state.center - r.body.model.mass.center; }
double rotation_angle(const RigidInput& r) {
  const Quaternion& q = r.body.state.rotation;
  return 2 * std::atan2(norm(Vec3d{q[1], q[2], q[3]}), std::abs(q[0])) * 180 / std::numbers::pi;
}

const Quantity<RigidInput> kRigid[] = {
    {"name", kNone, "", [](const RigidInput& r) -> Json { return r.body.name; }, kInReport},
    {"model", kNone, "", [](const RigidInput&) -> Json { return model_name(BodyKind::kRigid); }, kInReport},
    {"shape", kNone, "shape",
     [](const RigidInput& r) -> Json { return std::visit(RigidShapeText{}, r.scene.shape); }},
    {"mass", kGrams, "mass", [](const RigidInput& r) -> Json { return r.body.model.mass.mass; }, kEverywhere},
    {"fixed", kNone, "fixed", [](const RigidInput& r) -> Json { return r.body.model.is_fixed; }},
    {"vertices", kCount, "vertices",
     [](const RigidInput& r) -> Json { return r.body.model.vertices.size(); }},
    {"displacement", kMillimeters, "displacement of the center of mass, at the end",
     [](const RigidInput& r) -> Json { return norm(position_change(r)); }, kEverywhere},
    {"center_x", kMeters, "", [](const RigidInput& r) -> Json { return r.body.state.center.x; }, kInReport},
    {"center_y", kMeters, "", [](const RigidInput& r) -> Json { return r.body.state.center.y; }, kInReport},
    {"center_z", kMeters, "", [](const RigidInput& r) -> Json { return r.body.state.center.z; }, kInReport},
    {"rotation", kDegrees, "rotation, at the end",
     [](const RigidInput& r) -> Json { return rotation_angle(r); }, kEverywhere},
    {"speed", kSpeed, "speed of the center of mass, at the end",
     [](const RigidInput& r) -> Json { return norm(r.body.state.velocity); }},
    {"kinetic_energy", kJoules, "kinetic energy, at the end",
     [](const RigidInput& r) -> Json { return rigid::kinetic_energy(r.body.model, r.body.state); }},
};

}  // namespace

Json report_body(const ReportInput&, const RigidScene& scene, const RigidBody& body, BodyId) {
  return values_of(kRigid, RigidInput{scene, body});
}

Section rigid_section() {
  return {"Rigid bodies", "body", [](const Json& report) { return bodies_of(report, BodyKind::kRigid); },
          captions_of(kRigid)};
}

}  // namespace turgor

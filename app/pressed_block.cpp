#include "app/pressed_block.hpp"

#include "turgor/contact/touch.hpp"
#include "turgor/models/sfem/patch_assembly.hpp"

namespace turgor {

namespace {

constexpr std::size_t kMemory = std::size_t(8) << 30;  // limit of the store [bytes]
constexpr int kSites = 512;                            // contact sites, enough to avoid clustering

}  // namespace

sfem::Body held(SolidMesh mesh, sfem::Material material, const std::function<bool(Vec3d)>& is_fixed) {
  sfem::Body body;
  for (const Vec3d x : mesh.vertices) body.fixed.push_back(is_fixed(x));
  body.mesh = std::move(mesh);
  body.materials = {material};
  return body;
}

Result<sfem::Model> solved(const Exec& exec, sfem::Body body, const sfem::Params& params, bool on_demand) {
  Result<sfem::Model> model = sfem::build(exec, std::move(body), params);
  if (!model) return model;
  const Status made =
      on_demand ? sfem::prepare_columns(exec, *model) : sfem::compute_green(exec, *model, kMemory);
  if (!made) return made.error();
  return model;
}

sfem::Patch patch_at(const Exec& exec, sfem::Model& model, Vec3d point, sfem::PatchParams params) {
  const std::vector<Vec3d> touches{point};
  const std::vector<int> elements = sfem::patch_elements(model, touches, params.radius);
  std::vector<int> vertices;
  for (const int e : sfem::changed_elements(model, elements))
    for (const int v : element(model.body.mesh, std::size_t(e))) vertices.push_back(v);
  if (!model.green.columns.empty()) sfem::fetch_columns(exec, model, vertices);
  return sfem::build_patch(model, elements, params.refinement, touches).value();
}

std::vector<std::pair<double, double>> press(const sfem::Patch& patch, Vec3d point, double radius,
                                             double depth, int steps) {
  contact::TouchParams params;
  params.capacity = kSites;
  contact::TouchState state = contact::make_touch_state(patch, 1, params);
  const std::vector<contact::Tool> tools{{contact::Sphere{radius}, 0.0}};
  std::vector<contact::ToolPose> poses(1);
  std::vector<contact::ToolForce> forces(1);
  std::vector<std::pair<double, double>> curve;
  for (int step = 0; step <= steps; step++) {
    const double d = depth * step / steps;
    poses[0].pose.position = point + Vec3d{0, 0, radius - d};
    for (int settle = 0; settle < 3; settle++)
      contact::solve_touch_tick(patch, state, tools, poses, 1e-3, forces);
    curve.emplace_back(d, forces[0].force.z);
  }
  return curve;
}

}  // namespace turgor

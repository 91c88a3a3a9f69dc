#include "app/needle_block.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "app/pressed_block.hpp"
#include "turgor/geometry/hex_block.hpp"

namespace turgor {

Result<sfem::InnerGreen> inner_green_of(const Exec& exec, const NeedleBlock& block) {
  // mesh, held at its bottom or at its sides
  const auto count = [&](double extent) { return std::max(1, int(std::lround(extent / block.edge))); };
  SolidMesh mesh = hex_block(block.size, {count(block.size.x), count(block.size.y), count(block.size.z)});
  if (block.is_quadratic) mesh = tetrahedralize(mesh);
  const auto is_held = [&](Vec3d x) {
    if (!block.are_sides_held) return x.z < 1e-9;
    return x.x < 1e-9 || x.y < 1e-9 || x.x > block.size.x - 1e-9 || x.y > block.size.y - 1e-9;
  };
  sfem::Body body = held(std::move(mesh), {block.young, block.poisson}, is_held);
  if (block.is_quadratic) body = sfem::with_middles(std::move(body));
  Result<sfem::Model> model =
      sfem::build(exec, std::move(body), {.formulation = sfem::Formulation::kAveraged});
  if (!model) return model.error();
  if (const Status status = sfem::factorize(exec, *model); !status) return status.error();
  // elements around the axis
  std::vector<int> elements;
  for (std::size_t e = 0; e < element_count(model->body.mesh); e++) {
    const Vec3d d = centroid(model->body.mesh, e) - block.axis;
    if (block.axis == Vec3d{} || std::hypot(d.x, d.y) < block.edge) elements.push_back(int(e));
  }
  return sfem::make_inner_green(exec, *model, std::move(elements));
}

NeedlePush needle_above(const sfem::InnerGreen& inner, const contact::Needle& needle, Vec3d entry,
                        double tilt, double around) {
  const Vec3d z{std::sin(tilt) * std::cos(around), std::sin(tilt) * std::sin(around), std::cos(tilt)};
  const Vec3d x = normalized(cross(Vec3d{0.3, 1, 0}, z));
  return {inner,
          needle,
          entry,
          {entry + z * 0.001, {{x, cross(z, x), z}}},
          contact::make_needle_state(inner, needle)};
}

void push_to(NeedlePush& push, double depth, double step, const std::function<void(double, double)>& visit) {
  const Vec3d z = push.pose.axes.column[2];
  const auto depth_now = [&] { return -dot(push.pose.position - push.entry, z); };
  const int ticks = std::max(1, int(std::lround(std::abs(depth - depth_now()) / step)));
  const double each = (depth - depth_now()) / ticks;
  for (int i = 0; i < ticks; i++) {
    push.pose.position -= z * each;
    const contact::ToolReading reading = tick_needle(push.inner, push.needle, {}, push.pose, 1, push.state);
    if (visit) visit(depth_now(), dot(reading.force, z));
  }
}

double energy_error(const contact::NeedleWork& work) {
  return (work.cutting + work.friction + work.spreading + work.elastic) / work.hand - 1;
}

}  // namespace turgor

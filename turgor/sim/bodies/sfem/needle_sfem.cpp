#include "turgor/sim/bodies/sfem/needle_sfem.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"

namespace turgor {

namespace {

/// Shaft of a needle from its tip, at one time of its path.
struct Shaft {
  Vec3d tip, end;  // [m]
};

/// Shafts at the rows of a path and between them.
void add_shafts(const TouchingTool& tool, std::vector<Shaft>& shafts) {
  constexpr int kBetween = 8;
  constexpr std::size_t kMostRows = 100;
  const std::vector<PathRow>& rows = tool.path.rows;
  const std::size_t stride = std::max<std::size_t>(1, rows.size() / kMostRows);
  for (std::size_t r = 0; r < rows.size(); r += stride)
    for (int i = 0; i < kBetween; i++) {
      const double until = r + stride < rows.size() ? rows[r + stride].time : rows[r].time;
      const PathRow row = path_at(tool.path, rows[r].time + (until - rows[r].time) * i / kBetween);
      const Vec3d up = axes_of(row.orientation).column[2];
      shafts.push_back({row.position, row.position + up * tool.tool.needle->length});
    }
}

double distance_to(const Shaft& shaft, Vec3d x) {
  const Vec3d along = shaft.end - shaft.tip;
  const double s = std::clamp(dot(x - shaft.tip, along) / dot(along, along), 0.0, 1.0);
  return norm(shaft.tip + along * s - x);
}

/// Elements that a shaft passes at these positions of the mesh's vertices, or comes near to while they are
/// deformed.
std::vector<int> elements_near(const SolidMesh& mesh, const std::vector<Vec3d>& x,
                               const std::vector<Shaft>& shafts) {
  constexpr double kMargin = 0.004;  // [m]
  std::vector<int> elements;
  for (std::size_t e = 0; e < element_count(mesh); e++) {
    const auto corners = element(mesh, e);
    Vec3d center;
    for (const int v : corners) center += x[std::size_t(v)] / double(corners.size());
    double reach = 0;
    for (const int v : corners) reach = std::max(reach, norm(x[std::size_t(v)] - center));
    const bool is_near = std::any_of(shafts.begin(), shafts.end(), [&](const Shaft& shaft) {
      return distance_to(shaft, center) < reach + kMargin;
    });
    if (is_near) elements.push_back(int(e));
  }
  return elements;
}

/// Positions of all vertices: moved by tools, needles and everything else [m].
std::vector<Vec3d> present_positions(const SfemBody& body) {
  std::vector<Vec3d> x = body.model.body.mesh.vertices;
  for (const std::vector<Vec3d>* u : {&body.free.now, &body.needles.by_tools})
    for (std::size_t v = 0; v < u->size(); v++) x[v] += (*u)[v];
  return x;
}

std::size_t vertex_count_of(const SolidMesh& mesh, const std::vector<int>& elements) {
  std::vector<std::uint8_t> used(mesh.vertices.size(), 0);
  for (const int e : elements)
    for (const int v : element(mesh, std::size_t(e))) used[std::size_t(v)] = 1;
  return std::size_t(std::count(used.begin(), used.end(), 1));
}

bool has_force(const std::vector<Vec3d>& forces) {
  return std::any_of(forces.begin(), forces.end(), [](Vec3d f) { return !(f == Vec3d{}); });
}

/// Adds the values at these vertices of the mesh.
void add_at(const std::vector<int>& vertices, const std::vector<Vec3d>& of_mesh, std::vector<Vec3d>& sum) {
  sum.resize(vertices.size());
  if (of_mesh.empty()) return;
  for (std::size_t i = 0; i < vertices.size(); i++) sum[i] += of_mesh[std::size_t(vertices[i])];
}

/// Updates the largest displacement of each inner region by needles.
void measure_targets(SfemBody& body) {
  for (std::size_t r = 0; r < body.inside.size(); r++) {
    const std::vector<int>& vertices = body.inside[r].vertices;
    Vec3d sum;
    for (const std::vector<Vec3d>& u : body.needles.displacement)
      for (std::size_t i = 0; i < vertices.size() && !u.empty(); i++) sum += u[std::size_t(vertices[i])];
    const double mean = norm(sum) / double(std::max<std::size_t>(1, vertices.size()));
    body.needles.target_motion[r] = std::max(body.needles.target_motion[r], mean);
  }
}

/// Green's functions between the vertices of these elements, with their toughness; kept until no thread has
/// them.
std::shared_ptr<const sfem::InnerGreen> solve_inner(const Exec& exec, SfemBody& body,
                                                    std::vector<int> elements) {
  sfem::InnerGreen inner = sfem::make_inner_green(exec, body.model, std::move(elements));
  for (const int material : inner.material) inner.toughness.push_back(body.toughness[std::size_t(material)]);
  NeedleDisplacement& needles = body.needles;
  needles.inner = std::make_shared<const sfem::InnerGreen>(std::move(inner));
  std::erase_if(needles.in_use, [](const auto& kept) { return kept.use_count() == 1; });
  needles.in_use.push_back(needles.inner);
  return needles.inner;
}

}  // namespace

Status prepare_needles(const Exec& exec, SfemBody& body, const std::vector<TouchingTool>& tools,
                       const Prony& viscosity) {
  // shafts of all needles
  std::vector<Shaft> shafts;
  for (const int t : body.tool_indices)
    if (const TouchingTool& tool = tools[std::size_t(t)]; tool.tool.needle) add_shafts(tool, shafts);
  if (shafts.empty()) return Done{};
  if (pair_count(viscosity) > 0)
    return Error{
        "a needle needs an elastic body, found viscosity: its force on viscous tissue is not modeled yet"};
  if (body.law) return Error{"a needle needs a linear body, found a law"};
  // elements around them
  const SolidMesh& mesh = body.model.body.mesh;
  std::vector<int> elements = elements_near(mesh, mesh.vertices, shafts);
  const double bytes = double(sfem::inner_green_bytes(vertex_count_of(mesh, elements)));
  if (bytes > double(body.patch_memory))
    return Error{fmt::format(
        "Green's functions around the needles would take {:.3g} GB, the limit is {:.3g} GB: raise "
        "memory, or use a coarser mesh or a shorter needle",
        bytes * 1e-9, double(body.patch_memory) * 1e-9)};
  // their Green's functions
  if (const Status status = sfem::factorize(exec, body.model); !status) return status.error();
  contact::add_needles(body.touch, solve_inner(exec, body, std::move(elements)));
  contact::publish(body.touch, body.now);
  body.needles.displacement.resize(body.tool_indices.size());
  body.needles.motion.resize(body.tool_indices.size());
  body.needles.target_motion.resize(body.inside.size());
  return Done{};
}

void follow_needles(const Exec& exec, SfemBody& body) {
  if (!body.needles.inner) return;
  // elements around the shafts, and some distance ahead of them
  constexpr double kAhead = 0.03;  // [m]
  std::vector<Shaft> shafts;
  for (std::size_t t = 0; t < body.tool_indices.size(); t++) {
    const std::optional<contact::Needle>& needle = body.touch.tools[t].needle;
    const contact::Pose& pose = body.now.poses[t].pose;
    if (!needle || !contact::is_valid(pose)) continue;
    const Vec3d up = pose.axes.column[2];
    shafts.push_back(
        {pose.position - up * std::min(kAhead, needle->length), pose.position + up * needle->length});
  }
  std::vector<int> elements = elements_near(body.model.body.mesh, present_positions(body), shafts);
  const std::vector<int>& known = body.needles.inner->elements;
  if (std::includes(known.begin(), known.end(), elements.begin(), elements.end())) return;
  // with those of all tracks, if they fit into memory
  elements.insert(elements.end(), body.now.track_elements.begin(), body.now.track_elements.end());
  sort_unique(elements);
  const std::size_t vertices = vertex_count_of(body.model.body.mesh, elements);
  if (double(sfem::inner_green_bytes(vertices)) <= double(body.patch_memory))
    (void)solve_inner(exec, body, std::move(elements));
}

void restore_needles(const Exec& exec, SfemBody& body) {
  const std::shared_ptr<const sfem::InnerGreen> newest = body.needles.inner,
                                                in_use = body.touch.needles.inner;
  if (!newest) return;
  const auto solved = [&](const std::shared_ptr<const sfem::InnerGreen>& inner) {
    return inner->vertices.empty() ? solve_inner(exec, body, inner->elements) : inner;
  };
  body.touch.needles.inner = body.now.inner = solved(in_use);
  body.needles.inner = newest->elements == in_use->elements ? body.touch.needles.inner : solved(newest);
}

void displace_by_needles(SfemBody& body) {
  const std::shared_ptr<const sfem::InnerGreen> inner = body.now.inner;
  if (!inner) return;
  // displacement by each needle
  const std::size_t count = body.tool_indices.size();
  int needles = 0;
  for (std::size_t t = 0; t < count; t++) {
    const std::vector<Vec3d>& forces = body.now.needle_forces[t];
    needles += !forces.empty();
    std::vector<Vec3d>& u = body.needles.displacement[t];
    if (!has_force(forces)) {
      std::fill(u.begin(), u.end(), Vec3d{});
      continue;
    }
    std::vector<contact::VertexForce> loads;
    for (std::size_t i = 0; i < forces.size(); i++) loads.push_back({inner->vertices[i], forces[i]});
    u = displacement_by_factor(body.model, loads);
  }
  measure_targets(body);
  // motion around each needle by everything else: other needles, other tools, rotations, cloth, other bodies
  const bool has_others = std::size_t(needles) < count;
  if (needles < 2 && !has_others && !body.turning && !body.press && !body.coupling && !body.flight) return;
  std::vector<Vec3d>& others = body.needles.by_tools;
  if (has_others) others = displacement_by_factor(body.model, coarse_forces_now(body));
  for (std::size_t t = 0; t < count; t++) {
    if (body.now.needle_forces[t].empty()) continue;
    std::vector<Vec3d>& motion = body.needles.motion[t];
    const std::vector<int>& vertices = body.needles.inner->vertices;
    motion.assign(vertices.size(), {});
    add_at(vertices, others, motion);
    if (body.turning) add_at(vertices, body.turning->state.free, motion);
    if (body.press) add_at(vertices, body.press->displacement, motion);
    if (body.coupling) add_at(vertices, body.coupling->displacement, motion);
    if (body.flight) add_at(vertices, body.flight->displacement, motion);
    for (std::size_t other = 0; other < count; other++)
      if (other != t) add_at(vertices, body.needles.displacement[other], motion);
  }
}

}  // namespace turgor

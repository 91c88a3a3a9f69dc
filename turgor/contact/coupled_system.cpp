#include "turgor/contact/coupled_system.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/models/rhombus/spread.hpp"
#include "turgor/models/sfem/green.hpp"

namespace turgor::contact {

namespace {

constexpr double kSiteSoftness = 1e-5;  // see TouchParams::tool_softness
constexpr double kRigidSoftness =
    1e-3;  // the same between rigid bodies, whose sites share a load in many ways

/// A vertex that a tie or a site moves, or a point of a rigid body, with its signed weight.
struct Carrier {
  int body = 0, vertex = 0;  // of its mesh, then its index in number_vertices; -1 = rigid
  double weight = 0;
  Vec3d arm = {};  // of a point of a rigid body, from the center of mass [m]
};
/// All vertices of one tie or site that can move.
struct Carriers {
  std::array<Carrier, 6> list;
  std::size_t count = 0;
};

/// Present arm of a point of a rigid body.
Vec3d arm_of(const RigidMotion& motion, const SurfacePoint& point) {
  return motion.before.axes * (point.rest - motion.rest_center) + point.offset;
}

/// Rotation vector of a rotation matrix, of less than half a turn.
Vec3d rotation_vector(const Mat3d& m) {
  const auto& [a, b, c] = m.column;
  const Vec3d twice_sine = {b.z - c.y, c.x - a.z, a.y - b.x};
  const double sine = norm(twice_sine) / 2, cosine = (a.x + b.y + c.z - 1) / 2;
  return sine > 0 ? twice_sine * (std::atan2(sine, cosine) / (2 * sine)) : Vec3d{};
}

/// Position after the frame of a point of a rigid body. A rolling point moves with its axis, and by the
/// rotation times its offset, so that a ball keeps its height while it rolls.
Vec3d position_after(const Pose& after, Vec3d turned, const RigidMotion& motion, const SurfacePoint& point) {
  return to_world(after, point.rest - motion.rest_center) + point.offset + cross(turned, point.offset);
}

/// Displacement at one arm by a force at another: column `axis` of h² (I/m − [r]× J⁻¹ [s]×).
Vec3d rigid_column(double translation, const Mat3d& rotation, Vec3d r, Vec3d s, int axis) {
  Vec3d force;
  force[axis] = 1;
  return translation * force + cross(rotation * cross(s, force), r);
}

void add_carriers(std::span<const CoupledBody> bodies, const SurfacePoint& point, double sign,
                  Carriers& carriers) {
  if (point.body < 0) return;
  TURGOR_CHECK(is_index(point.body, bodies.size()), "surface points belong to coupled bodies");
  const CoupledBody& body = bodies[std::size_t(point.body)];
  if (body.rigid) {
    carriers.list[carriers.count++] = {point.body, -1, sign, arm_of(*body.rigid, point)};
    return;
  }
  if (body.inertia) {
    const Vec3d x = point.rest + displacement_of(point, body.free) + point.offset;
    carriers.list[carriers.count++] = {point.body, -1, sign, x - body.inertia->center};
    return;
  }
  if (body.is_support) return;
  TURGOR_CHECK(body.model || body.chains, "surface points belong to coupled bodies");
  const auto is_fixed = [&](int v) { return body.model && body.model->free_node[std::size_t(v)] < 0; };
  for (int corner = 0; corner < 3; corner++) {
    const int v = point.vertex[corner];
    if (v < 0 || point.weight[corner] == 0 || is_fixed(v)) continue;
    carriers.list[carriers.count++] = {point.body, v, sign * point.weight[corner]};
  }
}

/// Blocks 3×3, column-major.
using SiteBlock = std::array<double, 9>;

void add_scaled(const SiteBlock& block, double factor, SiteBlock& sum) {
  for (std::size_t k = 0; k < 9; k++) sum[k] += factor * block[k];
}

/// Row of a vertex in the compliance of its body.
int numbered_vertex(const CoupledBody& body, int vertex) {
  return body.model ? body.model->green.slot[std::size_t(vertex)] : vertex;
}

/// Stored nodes of finite elements, or vertices of chains, that ties and sites move, ascending. Carriers
/// receive their index in this list.
std::vector<std::vector<int>> number_vertices(std::span<const CoupledBody> bodies,
                                              std::vector<Carriers>& carriers) {
  std::vector<std::vector<int>> slots(bodies.size());
  const auto for_each_vertex = [&](const auto& visit) {
    for (Carriers& of : carriers)
      for (std::size_t c = 0; c < of.count; c++)
        if (Carrier& carrier = of.list[c]; carrier.vertex >= 0)
          visit(carrier, slots[std::size_t(carrier.body)],
                numbered_vertex(bodies[std::size_t(carrier.body)], carrier.vertex));
  };
  for_each_vertex([](Carrier&, std::vector<int>& of_body, int slot) { of_body.push_back(slot); });
  for (std::vector<int>& of_body : slots) sort_unique(of_body);
  for_each_vertex([](Carrier& carrier, const std::vector<int>& of_body, int slot) {
    carrier.vertex = int(std::lower_bound(of_body.begin(), of_body.end(), slot) - of_body.begin());
  });
  return slots;
}

/// Column of blocks of C by the forces of one tie or site on one body.
struct BodyColumn {
  std::span<const CoupledBody> bodies;
  std::span<const Carriers> carriers;
  const std::vector<std::vector<int>>& slots;  // see number_vertices

  /// Adds the blocks of the rows from `first` on.
  void add(std::size_t first, const Carriers& column, int body, std::vector<SiteBlock>& blocks) const {
    const CoupledBody& of = bodies[std::size_t(body)];
    if (of.rigid) return add_rigid(first, column, body, of.rigid->translation, of.rigid->rotation, blocks);
    if (of.inertia)
      return add_rigid(first, column, body, of.inertia->translation, of.inertia->rotation, blocks);
    const std::vector<SiteBlock> moved = displacements(column, body);
    for (std::size_t i = first; i < carriers.size(); i++)
      for (std::size_t r = 0; r < carriers[i].count; r++)
        if (const Carrier& row = carriers[i].list[r]; row.body == body)
          add_scaled(moved[std::size_t(row.vertex)], row.weight, blocks[i]);
  }

 private:
  /// Displacements of all numbered vertices of a body by unit forces of the column.
  std::vector<SiteBlock> displacements(const Carriers& column, int body) const {
    const CoupledBody& of = bodies[std::size_t(body)];
    const std::vector<int>& rows = slots[std::size_t(body)];
    std::vector<SiteBlock> moved(rows.size());
    for (std::size_t c = 0; c < column.count; c++) {
      if (column.list[c].body != body) continue;
      const double weight = column.list[c].weight / of.stiffness_scale;
      const int slot = rows[std::size_t(column.list[c].vertex)];
      for (std::size_t v = 0; v < rows.size(); v++) {
        SiteBlock block{};
        if (of.model)
          sfem::green_block(of.model->green, rows[v], slot, block);
        else
          rhombus::displacement_block(*of.chains, rows[v], slot, block);
        add_scaled(block, weight, moved[v]);
      }
    }
    return moved;
  }

  void add_rigid(std::size_t first, const Carriers& column, int body, double translation,
                 const Mat3d& rotation, std::vector<SiteBlock>& blocks) const {
    for (std::size_t c = 0; c < column.count; c++)
      for (std::size_t i = first; i < carriers.size(); i++)
        for (std::size_t r = 0; r < carriers[i].count; r++) {
          const Carrier &row = carriers[i].list[r], &of = column.list[c];
          if (row.body != body || of.body != body) continue;
          for (std::size_t k = 0; k < 9; k++)
            blocks[i][k] += row.weight * of.weight *
                            rigid_column(translation, rotation, row.arm, of.arm, int(k / 3))[int(k % 3)];
        }
  }
};

double mean_diagonal(const CoupledSystem& system, std::size_t s) {
  const std::size_t n = 3 * system.count;
  double sum = 0;
  for (std::size_t axis = 0; axis < 3; axis++) sum += system.compliance[(3 * s + axis) * (n + 1)];
  return sum / 3;
}

/// Sets the compliance of the sites: of those with tissue a fraction of the largest compliance, of others a
/// fraction of their own.
void set_softness(std::span<const CoupledBody> bodies, std::span<const PairSite> sites,
                  CoupledSystem& system) {
  const auto deforms = [&](const SurfacePoint& p) {
    return p.body >= 0 && (bodies[std::size_t(p.body)].model || bodies[std::size_t(p.body)].chains);
  };
  system.softness.assign(system.count, 0);
  double most = 0;
  for (std::size_t s = system.tie.size(); s < system.count; s++) {
    const PairSite& site = sites[s - system.tie.size()];
    if (deforms(site.a) || deforms(site.b))
      most = std::max(most, kSiteSoftness * mean_diagonal(system, s));
    else
      system.softness[s] = kRigidSoftness * mean_diagonal(system, s);
  }
  for (std::size_t s = system.tie.size(); s < system.count; s++)
    if (system.softness[s] == 0) system.softness[s] = most;
  for (std::size_t s = system.tie.size(); s < system.count; s++)
    if (const double own = sites[s - system.tie.size()].softness; own > 0) system.softness[s] = own;
}

/// Separation of a site without forces: the distance along its normal, and the slip across it.
Vec3d free_separation(std::span<const CoupledBody> bodies, const PairSite& site) {
  const auto at = [&](const SurfacePoint& p) { return p.rest + free_displacement(bodies, p); };
  const Vec3d n = site.normal, a = at(site.a);
  const Vec3d slip = a - at(site.anchor) - site.slip;
  const double distance = site.distance + dot(n, a - at(site.b) - site.found);
  return slip - dot(slip, n) * n + distance * n;
}

}  // namespace

void fill_system(const Exec& exec, std::span<const CoupledBody> bodies, std::span<const Tie> ties,
                 std::span<const PairSite> sites, CoupledSystem& system) {
  system.tie.clear(), system.free.clear();
  std::vector<Carriers> carriers;
  // ties, then sites
  for (std::size_t t = 0; t < ties.size(); t++) {
    if (ties[t].broken) continue;
    system.tie.push_back(t);
    system.free.push_back(free_stretch(bodies, ties[t]));
    add_carriers(bodies, ties[t].a, 1, carriers.emplace_back());
    add_carriers(bodies, ties[t].b, -1, carriers.back());
  }
  for (const PairSite& site : sites) {
    system.free.push_back(free_separation(bodies, site));
    add_carriers(bodies, site.a, 1, carriers.emplace_back());
    add_carriers(bodies, site.b, -1, carriers.back());
  }
  // compliance, column by column
  system.count = carriers.size();
  const std::size_t n = 3 * system.count;
  system.compliance.resize(n * n);
  const std::vector<std::vector<int>> slots = number_vertices(bodies, carriers);
  const BodyColumn of_body{bodies, carriers, slots};
  parallel_for(
      exec, system.count,
      [&](std::size_t j) {
        const Carriers& column = carriers[j];
        std::vector<SiteBlock> blocks(system.count);
        for (std::size_t c = 0; c < column.count; c++) {
          // once for each body of the column
          const int body = column.list[c].body;
          const auto same = [body](const Carrier& other) { return other.body == body; };
          if (std::none_of(column.list.begin(), column.list.begin() + std::ptrdiff_t(c), same))
            of_body.add(j, column, body, blocks);
        }
        for (std::size_t i = j; i < system.count; i++)
          for (std::size_t k = 0; k < 9; k++)
            system.compliance[(3 * j + k / 3) * n + 3 * i + k % 3] = blocks[i][k];
      },
      4);
  set_softness(bodies, sites, system);
}

Vec3d displacement_of(const SurfacePoint& point, std::span<const Vec3d> displacement) {
  Vec3d sum;
  if (point.body < 0) return sum;
  for (int corner = 0; corner < 3; corner++)
    if (const int v = point.vertex[corner]; v >= 0)
      sum += displacement[std::size_t(v)] * point.weight[corner];
  return sum;
}

Vec3d free_displacement(std::span<const CoupledBody> bodies, const SurfacePoint& point) {
  if (point.body < 0) return {};
  const CoupledBody& body = bodies[std::size_t(point.body)];
  if (!body.rigid) return displacement_of(point, body.free);
  const RigidMotion& motion = *body.rigid;
  const Vec3d caused = motion.shift + cross(motion.turn, arm_of(motion, point));
  return position_after(motion.after, motion.turned, motion, point) - caused - point.rest;
}

Vec3d free_stretch(std::span<const CoupledBody> bodies, const Tie& tie) {
  return free_displacement(bodies, tie.a) - free_displacement(bodies, tie.b);
}

RigidLoad load_on(int body, const RigidMotion& motion, std::span<const Tie> ties,
                  std::span<const PairSite> sites) {
  RigidLoad load;
  const auto add = [&](const SurfacePoint& point, Vec3d force) {
    if (point.body != body) return;
    load.force += force, load.torque += cross(arm_of(motion, point), force);
  };
  for (const Tie& tie : ties) add(tie.a, tie.force), add(tie.b, -tie.force);
  for (const PairSite& site : sites) add(site.a, site.force), add(site.b, -site.force);
  return load;
}

void linearize(const Pose& after, const RigidLoad& load, RigidMotion& motion) {
  motion.after = after;
  motion.turned = rotation_vector(after.axes * transposed(motion.before.axes));
  motion.shift = motion.translation * load.force, motion.turn = motion.rotation * load.torque;
}

double linearization_error(int body, const RigidMotion& motion, const Pose& after, const RigidLoad& load,
                           std::span<const Tie> ties, std::span<const PairSite> sites) {
  // changes of the load since the last solution
  const Vec3d shift = motion.translation * load.force - motion.shift;
  const Vec3d turn = motion.rotation * load.torque - motion.turn;
  const Vec3d turned = rotation_vector(after.axes * transposed(motion.before.axes));
  double largest = 0;
  const auto add = [&](const SurfacePoint& point) {
    if (point.body != body) return;
    const Vec3d linear = position_after(motion.after, motion.turned, motion, point) + shift +
                         cross(turn, arm_of(motion, point));
    largest = std::max(largest, norm(position_after(after, turned, motion, point) - linear));
  };
  for (const Tie& tie : ties) add(tie.a), add(tie.b);
  for (const PairSite& site : sites) add(site.a), add(site.b);
  return largest;
}

}  // namespace turgor::contact

#include "turgor/models/lattice/cutting/incision.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/key_index.hpp"
#include "turgor/core/number_text.hpp"
#include "turgor/geometry/box.hpp"
#include "turgor/models/lattice/cutting/blade_sheet.hpp"
#include "turgor/models/lattice/cutting/bone_stop.hpp"
#include "turgor/models/lattice/cutting/ct_skin.hpp"
#include "turgor/models/lattice/cutting/cut_fraction.hpp"
#include "turgor/models/lattice/cutting/cut_topology.hpp"
#include "turgor/models/lattice/cutting/drawn_curve.hpp"
#include "turgor/models/lattice/cutting/excision.hpp"
#include "turgor/models/lattice/cutting/fine_lattice.hpp"
#include "turgor/models/lattice/cutting/skin_near.hpp"
#include "turgor/models/lattice/cutting/undermine.hpp"
#include "turgor/models/lattice/mechanics/skin_queries.hpp"
#include "turgor/models/lattice/model/halo.hpp"

namespace turgor::lattice {

namespace {

/// Height of a blade's upper edge above the skin, in spacings. A cell with a node on the skin may be tilted,
/// so that it reaches √3 above that node, which may lie one spacing above the path. Cells whose edges in air
/// are not all cut would join the tissue on both sides.
constexpr double kAboveSkin = 3;

Vec3d tangent(const std::vector<Vec3d>& points, std::size_t n) {
  TURGOR_CHECK(n < points.size(), "a tangent is at a point of the curve");
  return normalized(points[std::min(n + 1, points.size() - 1)] - points[n > 0 ? n - 1 : 0]);
}

/// Direction into the body at every point of a curve: computed every centimeter and interpolated. A straight
/// line has the same direction everywhere.
std::vector<Vec3d> directions_into(const Lattice& lattice, const SkinNow& skin,
                                   const std::vector<Vec3d>& curve, bool straight) {
  constexpr double kSampleSpacing = 0.01;
  TURGOR_ASSERT(curve.size() >= 2, "a curve has at least two points");
  const double around = reach_of_directions(lattice);
  std::vector<Vec3d> into(curve.size());
  if (straight) {
    const Vec3d line = normalized(curve.back() - curve.front()),
                middle = (curve.front() + curve.back()) * 0.5;
    std::fill(into.begin(), into.end(), direction_into(skin, middle, line, around));
    return into;
  }
  // compute every centimeter, interpolate between
  const double spacing = norm(curve[1] - curve[0]);
  const auto stride = std::size_t(std::max(1.0, kSampleSpacing / std::max(spacing, 1e-6)));
  for (std::size_t n = 0; n < curve.size(); n += stride) {
    const std::size_t next = std::min(n + stride, curve.size() - 1);
    const Vec3d a = n > 0 ? into[n] : direction_into(skin, curve[n], tangent(curve, n), around);
    const Vec3d b = direction_into(skin, curve[next], tangent(curve, next), around);
    for (std::size_t m = n; m <= next; m++)
      into[m] = normalized(a + (b - a) * (next > n ? double(m - n) / double(next - n) : 0));
  }
  // orthogonal to the curve
  for (std::size_t n = 0; n < curve.size(); n++) {
    const Vec3d line = tangent(curve, n);
    into[n] = normalized(into[n] - line * dot(into[n], line));
  }
  return into;
}

/// Moving average over one and a half cells on both sides. It removes the steps of the lattice's skin.
std::vector<double> smooth_offsets(const std::vector<double>& offset) {
  constexpr std::size_t kReachPoints = 3;
  std::vector<double> smooth(offset.size());
  for (std::size_t n = 0; n < offset.size(); n++) {
    const std::size_t reach = std::min({kReachPoints, n, offset.size() - 1 - n});
    for (std::size_t m = n - reach; m <= n + reach; m++) smooth[n] += offset[m] / double(2 * reach + 1);
  }
  return smooth;
}

void cut_edge(const Model& model, Cuts& cuts, int slot, int family) {
  TURGOR_CHECK(is_index(slot, cuts.cut.size()) && is_index(family, kFamilyCount),
               "an edge starts at a slot and belongs to one of the seven families");
  cuts.cut[std::size_t(slot)] |= std::uint8_t(1u << family);
  mark_rows(model, cuts, slot);
}

/// Cuts the pending fine edges that the blade reaches, except those that are already cut.
void cut_fine_edges(const Model& model, Cuts& cuts, const BladePath& path, double begin, double end,
                    int incision) {
  TURGOR_ASSERT(is_index(incision, 256), "the index of an incision is below 256");
  const FineLattice f = fine_lattice(model);
  KeyIndex cut_already;
  const auto key = [&](const CutEdge& e) { return fine_edge_key(f, fine_node(f, e), e.family); };
  for (const CutEdge& edge : cuts.edges) cut_already.find_or_add(key(edge));
  for (CutEdge edge : path.fine_edges) {
    if (double(edge.along) < begin || double(edge.along) >= end || cut_already.find(key(edge)) >= 0) continue;
    edge.incision = std::uint8_t(incision);
    cuts.edges.push_back(edge);
  }
}

/// Coordinates of a point relative to the path of a static region.
struct RegionPosition {
  double along, across, depth;  // arc length, distance to the right, depth below the skin [m]
  double bottom;                // depth of the region there [m]
};
RegionPosition region_position(const BladePath& path, Vec3d point) {
  TURGOR_ASSERT(!path.points.empty() && path.inward.size() == path.points.size() &&
                    path.depths.size() == path.points.size(),
                "every point of a path has a direction and a depth");
  // nearest point of the path, measured perpendicular to `into`
  std::size_t nearest = 0;
  for (std::size_t n = 0; n < path.points.size(); n++)
    if (norm(cross(point - path.points[n], path.inward[n])) <
        norm(cross(point - path.points[nearest], path.inward[nearest])))
      nearest = n;
  const Vec3d away = point - path.points[nearest];
  double along = dot(away, tangent_at(path, nearest));
  for (std::size_t n = 0; n < nearest; n++) along += norm(path.points[n + 1] - path.points[n]);
  return {along, dot(away, across_at(path, nearest)), dot(away, path.inward[nearest]), path.depths[nearest]};
}

/// Boxes around parts of a static region, of sixteen points of its path each. A node of the region is no
/// farther from the nearest point of the path than half the width across, its depth or `margin` along
/// `inward`, and a step of the path along it.
std::vector<Box> boxes_around_region(const BladePath& path, double margin) {
  constexpr std::size_t kPoints = 16;
  double step = 0;
  for (std::size_t n = 1; n < path.points.size(); n++)
    step = std::max(step, norm(path.points[n] - path.points[n - 1]));
  const double deepest = *std::max_element(path.depths.begin(), path.depths.end()),
               far = 0.5 * path.width + std::max(margin, deepest) + step;
  std::vector<Box> boxes;
  for (std::size_t n = 0; n < path.points.size(); n += kPoints) {
    Box box = box_around(std::span(path.points).subspan(n, std::min(kPoints, path.points.size() - n)));
    box.low -= Vec3d{far, far, far}, box.high += Vec3d{far, far, far};
    boxes.push_back(box);
  }
  return boxes;
}

/// Center of the floor of an excision [m], at its depth below a mean of the CT's skin around the middle of
/// its outline, without the steps of the lattice. Errors: bone above the floor, or a floor that is not in
/// tissue.
Result<Vec3d> middle_of_floor(const Model& model, const State& state, const SkinNow& near,
                              const BladePath& path) {
  // skin around the middle
  Vec3d center;
  for (std::size_t n = 1; n < path.points.size(); n++) center += path.points[n];
  center = center / double(path.points.size() - 1);
  const Vec3d inward = mean_inward(path);
  const double step = smallest_spacing(model.anatomy.lattice);
  std::vector<Vec3d> around;
  for (std::size_t n = 0; n < path.points.size(); n++) {
    const Vec3d away = path.points[n] - center,
                point = center + normalized(away) * std::min(0.5 * norm(away), 1.5 * step);
    if (const auto found = distance_to_skin(near, point, inward, away * 1e-3))
      around.push_back(point + inward * *found);
  }
  if (around.empty()) return Error{"no skin in the middle of the outline: expected a piece of skin"};
  // mean depth of the floor below the center
  const std::vector<double> heights =
      ct_skin_heights(model, state, around, std::vector<Vec3d>(around.size(), inward));
  double sum = 0;
  for (std::size_t n = 0; n < around.size(); n++)
    sum += dot(around[n] - center, inward) + path.depth - heights[n];
  const Vec3d middle = center + inward * (sum / double(around.size()));
  // the floor is in tissue
  for (std::size_t n = 0; n < path.points.size(); n++)
    for (const Vec3d bottom : {path.points[n] + path.inward[n] * path.depths[n], middle}) {
      const Vec3 h = model.anatomy.lattice.spacing;
      const Int3 node{int(std::lround(bottom.x / double(h.x))), int(std::lround(bottom.y / double(h.y))),
                      int(std::lround(bottom.z / double(h.z)))};
      const bool is_tissue =
          contains(model.anatomy.lattice, node) &&
          is_body(model.anatomy.tissue[std::size_t(node_slot(model.anatomy.lattice, node))]);
      if (!is_tissue)
        return Error{
            "the floor of the excision leaves the body: expected a depth that is smaller than the "
            "body is thick, found " +
            number_text(path.depth) + " m"};
    }
  return middle;
}

/// Depths of the walls of an excision below the skin of the nodes: the CT's skin lies above it [m].
std::vector<double> depths_below_ct_skin(const Model& model, const State& state, const BladePath& path) {
  std::vector<double> depths = smooth_offsets(ct_skin_heights(model, state, path.points, path.inward));
  for (double& depth : depths) depth = std::max(0.0, path.depth - depth);
  depths.back() = depths.front();
  return depths;
}

/// Moves the outline of an excision from the outermost nodes to the skin of partial cells, which bears. Sizes
/// of the piece and of the wound are those of points on the outline.
void raise_to_patches(const Model& model, const State& state, BladePath& path) {
  const std::vector<double> heights = smooth_offsets(ct_skin_heights(model, state, path.points, path.inward));
  for (std::size_t n = 0; n < path.points.size(); n++) path.points[n] -= path.inward[n] * heights[n];
  path.points.back() = path.points.front();
}

}  // namespace

double path_length(const BladePath& path) {
  double length = 0;
  for (std::size_t n = 1; n < path.points.size(); n++) length += norm(path.points[n] - path.points[n - 1]);
  return length;
}

PathPosition position_along(const BladePath& path, double along) {
  for (std::size_t n = 0; n + 1 < path.points.size(); n++) {
    const double length = norm(path.points[n + 1] - path.points[n]);
    if (along <= length || n + 2 == path.points.size())
      return {n, length > 0 ? std::clamp(along / length, 0.0, 1.0) : 0};
    along -= length;
  }
  return {};
}

Vec3d across_at(const BladePath& path, std::size_t n) {
  TURGOR_CHECK(n < path.inward.size(), "a direction is at a point of the path");
  return normalized(cross(path.inward[n], tangent(path.points, n)));
}
Vec3d tangent_at(const BladePath& path, std::size_t n) { return cross(across_at(path, n), path.inward[n]); }

Vec3d mean_inward(const BladePath& path) {
  Vec3d sum;
  for (const Vec3d d : path.inward) sum += d;
  return normalized(sum);
}

Result<BladePath> lay_blade(const Model& model, const State& state, const Incision& incision,
                            const HaloExchange* halo, std::span<const LaidBlade> laid) {
  // validate the drawn points
  const std::vector<Vec3d> points = drawn_points(model, incision);
  const bool straight = points.size() == 2;
  const std::string prefix = (incision.excision ? "excision '" : "incision '") + incision.name + "': ";
  for (std::size_t n = 1; n < points.size(); n++)
    if (!(norm(points[n] - points[n - 1]) > 0))
      return Error{prefix +
                   (straight ? "from and to are the same point" : "two points of its path are the same") +
                   ": expected a line on the skin"};
  if (!model.params.skin.enabled)
    return Error{prefix + "the body has no skin to cut: expected skin to be on"};

  // drawn curve, joined to earlier incisions
  const double step = smallest_spacing(model.anatomy.lattice);
  std::vector<Vec3d> curve = drawn_curve(model, incision);
  std::array<JunctionLine, 2> met;
  if (incision.width == 0 && !incision.excision) met = join_laid_blades(model, state, laid, halo, curve);
  // skin near the curve
  const SkinNow near = skin_near(model, state.motion, curve, halo);
  if (near.empty()) return Error{off_skin(model, state.motion, prefix, curve[0])};
  BladePath path{.points = curve,
                 .inward = directions_into(model.anatomy.lattice, near, curve, straight),
                 .depth = incision.depth,
                 .width = incision.width,
                 .depths = std::vector<double>(curve.size(), incision.depth),
                 .edges = {},
                 .fine_edges = {},
                 .lines = {},
                 .is_excision = incision.excision.has_value()};
  // project the curve onto the skin
  std::vector<double> offset;
  for (std::size_t n = 0; n < curve.size(); n++) {
    if (norm(path.inward[n]) == 0)
      return Error{prefix + "the skin has no normal near the blade: expected it to face out of the body"};
    const std::optional<double> found =
        distance_to_skin(near, curve[n], path.inward[n], across_at(path, n) * (1e-4 * step));
    if (!found) return Error{off_skin(model, state.motion, prefix, curve[n])};
    offset.push_back(*found);
  }
  offset = smooth_offsets(offset);
  for (std::size_t n = 0; n < curve.size(); n++) path.points[n] += path.inward[n] * offset[n];
  if (path.is_excision) path.points.back() = path.points.front(), path.inward.back() = path.inward.front();
  if (path.is_excision && !model.anatomy.skin.patches.empty()) raise_to_patches(model, state, path);
  // depth at each point
  const double tilt = incision.tilt * std::numbers::pi / 180;
  if (!incision.through_bone) path.depths = depths_above_bone(model, state.motion, path, tilt, halo);
  // swept surface and the edges it crosses
  const double margin = kAboveSkin * largest_spacing(model.anatomy.lattice);
  if (incision.width > 0) return path;
  BladeSheet sheet;
  if (path.is_excision) {
    if (const double least = *std::min_element(path.depths.begin(), path.depths.end()); least < path.depth)
      return Error{prefix + "bone lies " + number_text(least) +
                   " m below the skin: expected a smaller depth, found " + number_text(path.depth) + " m"};
    path.depths = depths_below_ct_skin(model, state, path);
    const Result<Vec3d> middle = middle_of_floor(model, state, near, path);
    if (!middle) return Error{prefix + middle.error().message};
    sheet = excision_sheet(path, *middle, margin, 1e-4 * step);
  } else {
    sheet = sweep_blade(path, tilt, margin, 1e-4 * step);
    join_sheet(path, met, tilt, sheet);
  }
  if (incision.undermine.width > 0)
    add_undermining(model, state.motion, path, incision.undermine, halo, sheet);
  find_edges(model, state, sheet, halo, path);
  return path;
}

int cut_edges(const Model& model, State& state, const BladePath& path, double begin, double end, int incision,
              const DownloadNodes& download) {
  constexpr double kFar = std::numeric_limits<double>::max();
  TURGOR_ASSERT(begin <= end, "a blade cuts from the lower to the higher fraction");
  const double length = path_length(path);
  state.cuts.active_blades.set(std::uint8_t(incision), end < 1);
  begin = begin > 0 ? begin * length : -kFar, end = end < 1 ? end * length : kFar;
  int count = 0;
  // lattice edges that the blade reaches
  for (const PendingEdgeCut& edge : path.edges) {
    if (double(edge.along) < begin || double(edge.along) >= end) continue;
    if (state.cuts.cut[std::size_t(edge.slot)] >> edge.family & 1) continue;
    cut_edge(model, state.cuts, edge.slot, edge.family);
    count++;
  }
  // fine edges and sample lines that the blade reaches
  const std::size_t before = cut_version(state.cuts);
  cut_fine_edges(model, state.cuts, path, begin, end, incision);
  mark_cut_samples(model, state, path, begin, end, incision);
  // update skin and cut-cell elements
  if (count > 0) cut_skin(model, state.cuts);
  if (count > 0 || cut_version(state.cuts) > before) build_cut_elements(model, state, download);
  return count;
}

int cut_region(const Model& model, State& state, const BladePath& path) {
  const Lattice& l = model.anatomy.lattice;
  const double length = path_length(path), margin = 2 * largest_spacing(l);
  const std::vector<Box> boxes = boxes_around_region(path, margin);
  int count = 0;
  for (int k = 0; k < l.size.z; k++)
    for (int j = 0; j < l.size.y; j++)
      for (int i = 0; i < l.size.x; i++) {
        const Int3 node{i, j, k};
        // nodes inside the region
        const auto slot = std::size_t(node_slot(l, node));
        if (!is_body(model.anatomy.tissue[slot]) || state.cuts.removed[slot]) continue;
        const Vec3d x(position(model, state.motion, node));
        if (std::none_of(boxes.begin(), boxes.end(),
                         [x](const Box& b) { return squared_distance(b, x) == 0; }))
          continue;
        const RegionPosition position_in_region = region_position(path, x);
        if (std::abs(position_in_region.across) > 0.5 * path.width) continue;
        if (position_in_region.along < 0 || position_in_region.along > length ||
            position_in_region.depth < -margin || position_in_region.depth > position_in_region.bottom)
          continue;
        // remove the node and cut its edges
        state.cuts.removed[slot] = 1;
        count++;
        for (int f = 0; f < kFamilyCount; f++)
          for (const Int3 lower : {node, node - kFamilies[std::size_t(f)]})
            if (contains(l, lower) && contains(l, lower + kFamilies[std::size_t(f)]) &&
                has_node(model, node_slot(l, lower)))
              cut_edge(model, state.cuts, node_slot(l, lower), f);
      }
  state.cuts.removed_nodes += count;
  state.sleep.still_steps.clear();  // wakes all rows
  if (count > 0) cut_skin(model, state.cuts);
  if (count > 0) build_cut_elements(model, state);
  return count;
}

}  // namespace turgor::lattice

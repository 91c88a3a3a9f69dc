#include "turgor/contact/lattice_samples.hpp"

#include <algorithm>
#include <atomic>
#include <tuple>

#include "turgor/contact/lattice_points.hpp"
#include "turgor/core/invariants.hpp"
#include "turgor/core/sort_unique.hpp"
#include "turgor/geometry/triangle_tree.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/model/neighbors.hpp"

namespace turgor::contact {

namespace {

/// SurfaceSample::other of samples on lips, which have no other node.
constexpr int kOnLip = -2;

/// True when a node is at the tissue's boundary: next to air, or at the border of the scan.
bool is_outermost(const lattice::Model& model, Int3 node) {
  for (int n = 0; n < lattice::kNeighborCount; n++) {
    const Int3 other = node + lattice::neighbor_offset(n);
    if (!contains(model.anatomy.lattice, other)) return true;
    if (!is_body(model.anatomy.tissue[std::size_t(node_slot(model.anatomy.lattice, other))])) return true;
  }
  return false;
}

/// An outermost node and the nearest point of the displayed skin.
struct NodeSkinPoint {
  int slot = 0;
  Int3 node;
  Vec3d position;  // lattice frame [m]
};
std::vector<NodeSkinPoint> skin_points_of_nodes(const lattice::Model& model, const TriangleTree& skin) {
  std::vector<NodeSkinPoint> skin_points;
  const Int3 size = model.anatomy.lattice.size;
  for (int k = 0; k < size.z; k++)
    for (int j = 0; j < size.y; j++)
      for (int i = 0; i < size.x; i++) {
        // outermost nodes of the body
        const Int3 node{i, j, k};
        const int slot = node_slot(model.anatomy.lattice, node);
        if (!is_body(model.anatomy.tissue[std::size_t(slot)]) || !is_outermost(model, node)) continue;
        const Vec3d rest(rest_position(model.anatomy.lattice, node));
        skin_points.push_back({slot, node, nearest_point(skin, rest).position});
      }
  std::sort(skin_points.begin(), skin_points.end(),
            [](const NodeSkinPoint& a, const NodeSkinPoint& b) { return a.slot < b.slot; });
  return skin_points;
}

/// Adds samples halfway between the skin points of neighboring nodes, where a tool would sink in. Neighbors
/// above each other share one skin point, so close pairs are skipped.
void add_samples_between(const lattice::Model& model, const TriangleTree& skin,
                         const std::vector<NodeSkinPoint>& skin_points, std::vector<LatticeSample>& samples) {
  TURGOR_CHECK(is_sorted_unique(skin_points, &NodeSkinPoint::slot), "skin points ascend by node");
  const Vec3 h = model.anatomy.lattice.spacing;
  const double nearest = 0.5 * double(std::min({h.x, h.y, h.z}));
  for (const NodeSkinPoint& point : skin_points)
    for (const Int3 family : kFamilies) {
      // neighbor of the same surface
      const Int3 node = point.node + family;
      if (!contains(model.anatomy.lattice, node)) continue;
      const int slot = node_slot(model.anatomy.lattice, node);
      const auto other = std::lower_bound(skin_points.begin(), skin_points.end(), slot,
                                          [](const NodeSkinPoint& f, int sought) { return f.slot < sought; });
      if (other == skin_points.end() || other->slot != slot) continue;
      // skip pairs that are close
      if (!(norm(other->position - point.position) > nearest)) continue;
      // sample at the middle, carried by both nodes
      const Vec3d rest = nearest_point(skin, (point.position + other->position) * 0.5).position;
      samples.push_back({point.slot, rest, false, slot});
      samples.push_back({slot, rest, false, point.slot});
    }
}

/// True when a blade removed the sample's node or cut it from the other one.
bool is_detached(const lattice::Model& model, const lattice::Cuts& cuts, const LatticeSample& sample) {
  const auto removed = [&](int slot) { return cuts.removed[std::size_t(slot)] != 0; };
  if (removed(sample.slot)) return true;
  if (sample.other < 0) return false;
  const Int3 displacement =
      slot_node(model.anatomy.lattice, sample.other) - slot_node(model.anatomy.lattice, sample.slot);
  const bool up = family_of(displacement) >= 0;
  const int family = up ? family_of(displacement) : family_of(-displacement);
  const int lower = up ? sample.slot : sample.other;
  return removed(sample.other) || (cuts.cut[std::size_t(lower)] >> family & 1);
}

/// Adds one sample for every node that carries cut walls: the mean of its wall vertices.
void add_wall_samples(const lattice::Model& model, const lattice::BodySurface& surface,
                      std::vector<LatticeSample>& samples) {
  // wall vertices, ordered by node
  TURGOR_CHECK(surface.slot.size() == surface.rest.size(), "every vertex of the surface has a node");
  std::vector<int> walls;
  for (auto t = std::size_t(surface.skin_triangles); t < surface.triangles.size(); t++)
    for (int corner = 0; corner < 3; corner++) walls.push_back(surface.triangles[t][corner]);
  sort_unique(walls);
  const auto slot = [&](int v) { return surface.slot[std::size_t(v)]; };
  std::stable_sort(walls.begin(), walls.end(), [&](int a, int b) { return slot(a) < slot(b); });
  // mean over each node
  for (std::size_t begin = 0, end = 0; begin < walls.size(); begin = end) {
    Vec3d sum;
    for (; end < walls.size() && slot(walls[end]) == slot(walls[begin]); end++)
      sum += Vec3d(surface.rest[std::size_t(walls[end])]);
    if (model.anatomy.inverse_mass[std::size_t(slot(walls[begin]))] > 0)
      samples.push_back({slot(walls[begin]), sum / double(end - begin), true});
  }
}

/// Adds one sample for every node that carries lips of a wound: the lip vertex nearest to their mean. Samples
/// between nodes that the cut separates are gone, so that a tool would sink into the wound.
void add_lip_samples(const lattice::Model& model, const lattice::BodySurface& surface,
                     std::vector<LatticeSample>& samples) {
  // vertices of lips, ordered by node
  std::vector<int> lips;
  for (const lattice::Lip& lip : surface.lips) lips.push_back(lip.left), lips.push_back(lip.right);
  sort_unique(lips);
  const auto slot = [&](int v) { return surface.slot[std::size_t(v)]; };
  const auto rest = [&](int v) { return Vec3d(surface.rest[std::size_t(v)]); };
  std::stable_sort(lips.begin(), lips.end(), [&](int a, int b) { return slot(a) < slot(b); });
  // middle vertex of each node
  for (std::size_t begin = 0, end = 0; begin < lips.size(); begin = end) {
    Vec3d sum;
    for (; end < lips.size() && slot(lips[end]) == slot(lips[begin]); end++) sum += rest(lips[end]);
    if (!(model.anatomy.inverse_mass[std::size_t(slot(lips[begin]))] > 0)) continue;
    const Vec3d mean = sum / double(end - begin);
    const int middle =
        *std::min_element(lips.begin() + std::ptrdiff_t(begin), lips.begin() + std::ptrdiff_t(end),
                          [&](int a, int b) { return norm(rest(a) - mean) < norm(rest(b) - mean); });
    samples.push_back({slot(middle), rest(middle), false, kOnLip});
  }
}

auto key(const LatticeSample& sample) { return std::tuple(sample.slot, sample.wall, sample.other); }
bool comes_first(const LatticeSample& a, const LatticeSample& b) { return key(a) < key(b); }

/// Points of samples that were far from cuts, in the order of the new samples; null: none.
std::vector<const lattice::EmbeddedPoint*> known_points(const std::vector<LatticeSample>& before,
                                                        const LatticeTouch& touch) {
  std::vector<const lattice::EmbeddedPoint*> known(touch.samples.size(), nullptr);
  if (touch.is_far.size() != before.size()) return known;
  auto next = before.begin();
  for (std::size_t p = 0; p < known.size(); p++) {
    const LatticeSample& sample = touch.samples[p];
    while (next != before.end() && comes_first(*next, sample)) ++next;
    if (next == before.end() || key(*next) != key(sample) || !(next->rest == sample.rest)) continue;
    const auto n = std::size_t(next - before.begin());
    if (touch.is_far[n]) known[p] = &touch.points[n];
  }
  return known;
}

/// Embeds the samples in cells. One sample between two nodes is enough then. `before`: samples of the present
/// points.
void embed_in_cells(const lattice::Model& model, const lattice::Cuts& cuts,
                    const lattice::BodySurface& surface, const std::vector<LatticeSample>& before,
                    LatticeTouch& touch) {
  std::erase_if(touch.samples, [](const LatticeSample& p) { return p.other >= 0 && p.other < p.slot; });
  SamplePoints points = embed_samples(model, cuts, surface, touch.samples, known_points(before, touch));
  touch.points = std::move(points.at), touch.is_far = std::move(points.is_far);
  touch.virtual_slots.clear();
  for (const lattice::VirtualNode& node : surface.fragments->virtual_nodes)
    touch.virtual_slots.push_back(node.slot);
}

}  // namespace

std::vector<LatticeSample> skin_samples(const lattice::Model& model, const lattice::BodySurface& surface) {
  std::vector<LatticeSample> samples;
  if (surface.skin_triangles == 0) return samples;
  TURGOR_CHECK(surface.skin_triangles > 0 && std::size_t(surface.skin_triangles) <= surface.triangles.size(),
               "triangles of the skin come before those of the walls");
  // search tree of the skin's triangles
  const auto triangles = surface.triangles.begin();
  const TriangleTree skin = build_triangle_tree({surface.rest.begin(), surface.rest.end()},
                                                {triangles, triangles + surface.skin_triangles});
  // samples at nodes and between them
  const std::vector<NodeSkinPoint> skin_points = skin_points_of_nodes(model, skin);
  for (const NodeSkinPoint& point : skin_points) samples.push_back({point.slot, point.position});
  add_samples_between(model, skin, skin_points, samples);
  std::erase_if(samples, [&](const LatticeSample& p) {
    return !(model.anatomy.inverse_mass[std::size_t(p.slot)] > 0);
  });
  return samples;
}

void update_surface(LatticeTouch& touch, const lattice::Model& model, const lattice::Cuts& cuts,
                    const lattice::BodySurface& surface) {
  // new version; samples without those of wounds and detached ones
  static std::atomic<std::uint64_t> versions = 0;
  touch.version = ++versions;
  const std::vector<LatticeSample> before = touch.samples;
  std::erase_if(
      touch.samples,
      // samples of wounds
      [&](const LatticeSample& p) { return p.wall || p.other == kOnLip || is_detached(model, cuts, p); });
  // new walls; the other samples are sorted already, except at the first call
  if (!std::is_sorted(touch.samples.begin(), touch.samples.end(), comes_first))
    std::sort(touch.samples.begin(), touch.samples.end(), comes_first);
  const auto skin = std::ptrdiff_t(touch.samples.size());
  add_wall_samples(model, surface, touch.samples);
  if (touch.in_cells) add_lip_samples(model, surface, touch.samples);
  std::sort(touch.samples.begin() + skin, touch.samples.end(), comes_first);
  std::inplace_merge(touch.samples.begin(), touch.samples.begin() + skin, touch.samples.end(), comes_first);
  if (touch.in_cells) embed_in_cells(model, cuts, surface, before, touch);
  // contacts keep their samples, or end
  std::erase_if(touch.contacts, [&](LatticeContact& contact) {
    const LatticeSample& was = before[std::size_t(contact.sample)];
    const auto now = std::lower_bound(touch.samples.begin(), touch.samples.end(), was, comes_first);
    contact.sample = int(now - touch.samples.begin());
    return now == touch.samples.end() || key(*now) != key(was);
  });
}

}  // namespace turgor::contact

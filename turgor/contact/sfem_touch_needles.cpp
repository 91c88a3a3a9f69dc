// Needles of a touched sfem body: their motion, and a change of the Green's functions around them.
#include <algorithm>
#include <utility>

#include "turgor/contact/sfem_touch.hpp"
#include "turgor/core/assert.hpp"

namespace turgor::contact {

namespace {

/// Numbers the elements of a track in other Green's functions. False: they do not contain all of them.
bool renumber(const sfem::InnerGreen& from, const sfem::InnerGreen& to, NeedleTrack& track) {
  for (NeedlePoint& point : track.points) {
    const int element = from.elements[std::size_t(point.at.element)];
    const auto found = std::lower_bound(to.elements.begin(), to.elements.end(), element);
    if (found == to.elements.end() || *found != element) return false;
    point.at.element = int(found - to.elements.begin());
  }
  return true;
}

/// Carries a motion over to other Green's functions by the vertices of the mesh. Vertices that are new rest
/// at the position to which the motion goes next; empty = at zero. `free` is the workspace.
void renumber_motion(const sfem::InnerGreen& from, const sfem::InnerGreen& to, std::span<const Vec3d> next,
                     NeedleState& needle) {
  TURGOR_ASSERT(next.empty() || next.size() == to.vertices.size(), "one motion a vertex");
  const bool has_next = needle.motion.moves && !next.empty();
  for (std::vector<Vec3d>* list : {&needle.motion.from, &needle.motion.to}) {
    needle.free.assign(to.vertices.size(), {});
    std::size_t old = 0;  // both lists ascend
    for (std::size_t v = 0; v < to.vertices.size(); v++) {
      while (old < from.vertices.size() && from.vertices[old] < to.vertices[v]) old++;
      const bool is_known = old < from.vertices.size() && from.vertices[old] == to.vertices[v];
      needle.free[v] = is_known ? (*list)[old] : has_next ? next[v] : Vec3d{};
    }
    std::swap(needle.free, *list);
  }
  needle.free.assign(to.vertices.size(), {});
  for (std::size_t v = 0; v < needle.free.size() && needle.motion.moves; v++)
    needle.free[v] = interpolated_motion(needle.motion, v, path_fraction(needle.motion));
}

}  // namespace

void take_needle_motion(SfemTouch& touch, std::span<const std::vector<Vec3d>> to, long ticks) {
  TURGOR_ASSERT(to.empty() || to.size() == touch.needles.needles.size(), "one motion a tool");
  for (std::size_t t = 0; t < to.size(); t++) start_motion(touch.needles.needles[t].motion, to[t], ticks);
}

void add_needles(SfemTouch& touch, std::shared_ptr<const sfem::InnerGreen> inner) {
  touch.needles.inner = std::move(inner);
  const std::size_t vertices = touch.needles.inner->vertices.size(), most = touch.free.to.size();
  for (const Tool& tool : touch.tools) {
    NeedleState needle;
    if (tool.needle) {
      needle = make_needle_state(*touch.needles.inner, *tool.needle);
      for (auto* list : {&needle.free, &needle.motion.from, &needle.motion.to, &needle.force_on_vertex})
        list->reserve(std::max(most, vertices)), list->resize(vertices);
      needle.row.reserve(9 * std::max(most, vertices));
    }
    touch.needles.needles.push_back(std::move(needle));
  }
}

void list_track_elements(const NeedleTouch& touch, std::vector<int>& elements) {
  elements.clear();
  for (const NeedleState& needle : touch.needles)
    for (const NeedleTrack& track : needle.tracks)
      for (const NeedlePoint& point : track.points) {
        const int element = touch.inner->elements[std::size_t(point.at.element)];
        if (elements.empty() || elements.back() != element) elements.push_back(element);
      }
}

void take_inner(SfemTouch& touch, const std::shared_ptr<const sfem::InnerGreen>& inner,
                std::span<const std::vector<Vec3d>> to) {
  TURGOR_ASSERT(touch.needles.inner && inner, "needles have Green's functions");
  TURGOR_ASSERT(to.empty() || to.size() == touch.needles.needles.size(), "one motion a tool");
  const std::size_t vertices = inner->vertices.size();
  for (std::size_t t = 0; t < touch.needles.needles.size(); t++) {
    NeedleState& needle = touch.needles.needles[t];
    if (needle.tracks.empty()) continue;
    for (std::size_t n = 0; n < needle.tracks.size(); n++) {
      NeedleTrack& track = needle.tracks[n];
      if (renumber(*touch.needles.inner, *inner, track)) continue;
      track.points.clear(), track.length = 0;
      if (int(n) != needle.track) continue;
      needle.phase = NeedlePhase::kOutside, needle.inserted = 0, needle.tip_force = 0;
      needle.beam = {}, needle.carried_points = 0;
    }
    renumber_motion(*touch.needles.inner, *inner, to.empty() ? std::span<const Vec3d>() : to[t], needle);
    needle.force_on_vertex.assign(vertices, {});
    needle.row.assign(9 * vertices, 0);
  }
  touch.needles.inner = inner;
}

}  // namespace turgor::contact

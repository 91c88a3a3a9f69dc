// Encoding of numbers in a page: integers, stored as all lowest bytes, then all second bytes, and so on
// (similar adjacent bytes compress well), compressed by zlib, as base64.
//
// Positions are 16-bit fractions of a cube, each the difference from the one before. Displacements are 16-bit
// multiples of a quantum, each the difference from the previous frame of the same triangles. All x come
// first, then y and z.
#include "turgor/pictures/motion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <meshoptimizer.h>

#include "turgor/core/hash.hpp"
#include "turgor/io/files/base64.hpp"
#include "turgor/io/files/deflate.hpp"
#include "turgor/pictures/picture_items.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/view/color.hpp"

namespace turgor {

namespace {

constexpr int kByte = 1, kWord = 2,
              kIndex = 4;  // bytes of a color, of a position or displacement, of a vertex number

// ------------------------------------------------------------------------------------------------- adding

/// Reduces the triangles to at most `max_triangles` by edge collapses [Garland, Heckbert 1997]. Lips of
/// wounds that touch at rest stay separate, because they share no vertex.
std::vector<Int3> coarser(const std::vector<Int3>& triangles, const std::vector<Vec3>& rest,
                          std::size_t max_triangles) {
  if (triangles.size() <= max_triangles) return triangles;
  std::vector<unsigned> indices, kept(3 * triangles.size());
  for (const Int3 t : triangles)
    for (int corner = 0; corner < 3; corner++) indices.push_back(unsigned(t[corner]));
  constexpr float kLargestError = 0.05f;  // relative to the whole
  kept.resize(meshopt_simplify(kept.data(), indices.data(), indices.size(), &rest.data()->x, rest.size(),
                               sizeof(Vec3), 3 * max_triangles, kLargestError, 0, nullptr));
  std::vector<Int3> fewer;
  for (std::size_t i = 0; i < kept.size(); i += 3)
    fewer.push_back({int(kept[i]), int(kept[i + 1]), int(kept[i + 2])});
  return fewer;
}

/// An object in its current state.
struct CurrentThing {
  MovingThing thing;  // without surfaces
  std::vector<Int3> triangles;
  std::size_t wall_begin;
  std::vector<Vec3> rest, now;   // [m]
  std::vector<Rgb> colors = {};  // as of MovingSurface
};

MovingSurface make_surface(const CurrentThing& current, std::size_t max_triangles) {
  const std::vector<Int3>& triangles = current.triangles;
  const std::vector<Vec3>& rest = current.rest;
  MovingSurface surface;
  const auto split = triangles.begin() + std::ptrdiff_t(std::min(current.wall_begin, triangles.size()));
  surface.triangles = coarser({triangles.begin(), split}, rest, max_triangles);
  surface.wall_begin = surface.triangles.size();
  const std::vector<Int3> walls = coarser({split, triangles.end()}, rest, max_triangles / 2);
  surface.triangles.insert(surface.triangles.end(), walls.begin(), walls.end());
  std::vector<int> number(rest.size(), -1);
  for (Int3& t : surface.triangles)
    for (int corner = 0; corner < 3; corner++) {
      int& n = number[std::size_t(t[corner])];
      if (n < 0) n = int(surface.vertex.size()), surface.vertex.push_back(t[corner]);
      t[corner] = n;
    }
  for (const int v : surface.vertex) {
    surface.rest.push_back(rest[std::size_t(v)]);
    if (!current.colors.empty()) surface.colors.push_back(current.colors[std::size_t(v)]);
  }
  return surface;
}

/// Replaces walls by those with the colors of layers. Caps get vertices of their own, in the color of
/// sections.
void color_walls(const BodySnapshot& body, CurrentThing& current) {
  const ColoredWalls walls = colored_walls(body);
  if (walls.mesh.triangles.empty()) return;
  const std::size_t skin = current.rest.size();
  const auto add = [&](Vec3 rest, Vec3 now) { current.rest.push_back(rest), current.now.push_back(now); };
  // caps
  current.triangles.resize(body.wall_begin);
  std::vector<int> on_cap(skin, -1);
  for (std::size_t t = current.wall_begin; t < body.wall_begin; t++)
    for (int corner = 0; corner < 3; corner++) {
      const auto v = std::size_t(body.triangles[t][corner]);
      if (on_cap[v] < 0) on_cap[v] = int(current.rest.size()), add(body.rest[v], body.x[v]);
      current.triangles[t][corner] = on_cap[v];
    }
  current.colors.assign(skin, {255, 255, 255});
  current.colors.resize(current.rest.size(), section_color(body));
  // walls
  const int first = int(current.rest.size());
  for (const Int3 t : walls.mesh.triangles) current.triangles.push_back(t + Int3{first, first, first});
  for (std::size_t v = 0; v < walls.mesh.vertices.size(); v++) {
    Vec3 rest;
    for (int corner = 0; corner < 3; corner++)
      rest += body.rest[std::size_t(body.wall_layers.corner[v][corner])] * body.wall_layers.weight[v][corner];
    add(rest, walls.mesh.vertices[v]);
  }
  current.colors.insert(current.colors.end(), walls.colors.begin(), walls.colors.end());
}

CurrentThing thing_of_body(const BodySnapshot& body) {
  MovingThing thing{MovingThing::Kind::kBody, body.name, body.look, body.typical_force, {}};
  CurrentThing current{std::move(thing), body.triangles, outer_triangles(body).size(), body.rest, body.x};
  color_walls(body, current);
  return current;
}

CurrentThing thing_of_inside(const BodySnapshot& body) {
  return {{MovingThing::Kind::kInside, body.name, Look::kFlesh, 1, {}},
          body.inside.triangles,
          body.inside.triangles.size(),
          body.inside.vertices,
          body.inside.vertices};
}

CurrentThing thing_of_tool(const ToolSnapshot& tool) {
  CurrentThing current{
      {MovingThing::Kind::kTool, tool.name, Look::kFlesh, 1, {}}, tool.mesh.triangles, 0, {}, {}};
  current.wall_begin = tool.mesh.triangles.size();
  for (const Vec3 x : tool.mesh.vertices) current.now.push_back(Vec3(contact::to_world(tool.pose, Vec3d(x))));
  current.rest = current.now;
  return current;
}

CurrentThing thing_of_obstacle(const TriMesh& mesh) {
  return {{MovingThing::Kind::kObstacle, "", Look::kFlesh, 1, {}},
          mesh.triangles,
          mesh.triangles.size(),
          mesh.vertices,
          mesh.vertices};
}

std::size_t numbers_in(const MovingSurface& surface) {
  return surface.vertex.size() + 3 * (surface.rest.size() + surface.triangles.size()) + surface.colors.size();
}

std::size_t numbers_in(const MotionFrame& frame) {
  std::size_t numbers = 0;
  for (const auto& moved : frame.moved) numbers += 3 * moved.size();
  return numbers;
}

void add_thing(const CurrentThing& current, std::size_t at, std::size_t max_triangles, Motion& motion,
               MotionFrame& frame) {
  if (at == motion.things.size()) motion.things.push_back(current.thing);
  MovingThing& thing = motion.things[at];
  const std::uint64_t key = hash_values(std::span<const Int3>(current.triangles), current.rest.size());
  if (thing.surfaces.empty() || thing.surfaces.back().key != key) {
    thing.surfaces.push_back(make_surface(current, max_triangles));
    thing.surfaces.back().key = key;
    motion.numbers += numbers_in(thing.surfaces.back());
  }
  const MovingSurface& surface = thing.surfaces.back();
  std::vector<Vec3> moved;
  moved.reserve(surface.vertex.size());
  for (std::size_t v = 0; v < surface.vertex.size(); v++)
    moved.push_back(current.now[std::size_t(surface.vertex[v])] - surface.rest[v]);
  frame.surface.push_back(thing.surfaces.size() - 1);
  frame.moved.push_back(std::move(moved));
}

bool is_shown(const std::vector<MotionFrame>& frames, std::size_t thing, std::size_t surface) {
  return std::any_of(frames.begin(), frames.end(),
                     [&](const MotionFrame& f) { return f.surface[thing] == surface; });
}

/// Drops every second frame, with the surfaces that only it used; keeps the first and the last.
void thin(Motion& motion) {
  std::vector<MotionFrame> kept;
  motion.numbers = 0;
  for (std::size_t f = 0; f < motion.frames.size(); f++) {
    if (f % 2 != 0 && f + 1 != motion.frames.size()) continue;
    motion.numbers += numbers_in(motion.frames[f]);
    kept.push_back(std::move(motion.frames[f]));
  }
  motion.frames = std::move(kept);
  for (std::size_t t = 0; t < motion.things.size(); t++) {
    std::vector<MovingSurface>& surfaces = motion.things[t].surfaces;
    for (std::size_t s = 0; s < surfaces.size(); s++) {
      if (is_shown(motion.frames, t, s))
        motion.numbers += numbers_in(surfaces[s]);
      else
        surfaces[s] = {};
    }
  }
}

// ------------------------------------------------------------------------------------------------ writing

std::string packed(const std::vector<std::int32_t>& numbers, int bytes) {
  std::string planes;
  planes.reserve(numbers.size() * std::size_t(bytes));
  for (int b = 0; b < bytes; b++)
    for (const std::int32_t n : numbers) planes += char(std::uint32_t(n) >> (8 * b) & 255);
  std::string small;
  io::deflate({planes}, io::Deflate::kZlib, [&small](std::string_view piece) { small += piece; });
  return io::base64(small);
}

/// Differences of consecutive numbers, modulo 16 bits.
std::vector<std::int32_t> differences(const std::vector<std::int32_t>& numbers) {
  std::vector<std::int32_t> result(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); i++) result[i] = numbers[i] - (i > 0 ? numbers[i - 1] : 0);
  return result;
}

Json json_of(Vec3d v) { return Json::array({v.x, v.y, v.z}); }

Json json_of(const MovingSurface& surface) {
  constexpr float kFar = std::numeric_limits<float>::max();
  Vec3 low{kFar, kFar, kFar}, high = -low;
  for (const Vec3 x : surface.rest) low = min(low, x), high = max(high, x);
  if (surface.rest.empty()) low = high = {};
  const Vec3 extent = high - low;
  const double size = std::max({double(extent.x), double(extent.y), double(extent.z), 1e-9});
  std::vector<std::int32_t> positions, corners;
  for (int axis = 0; axis < 3; axis++)
    for (const Vec3 x : surface.rest)
      positions.push_back(std::int32_t(std::lround((double(x[axis]) - double(low[axis])) / size * 65535)));
  for (const Int3 t : surface.triangles)
    for (int corner = 0; corner < 3; corner++) corners.push_back(t[corner]);
  Json json{{"low", json_of(Vec3d(low))},       {"size", size},
            {"vertices", surface.rest.size()},  {"positions", packed(differences(positions), kWord)},
            {"wall_begin", surface.wall_begin}, {"triangles", packed(differences(corners), kIndex)}};
  if (!surface.colors.empty()) {
    std::vector<std::int32_t> channels;
    for (const Rgb color : surface.colors) channels.insert(channels.end(), {color.r, color.g, color.b});
    json["colors"] = packed(channels, kByte);
  }
  return json;
}

double largest_component(const Motion& motion, std::size_t thing) {
  float largest = 0;
  for (const MotionFrame& frame : motion.frames)
    for (const Vec3 u : frame.moved[thing])
      largest = std::max({largest, std::abs(u.x), std::abs(u.y), std::abs(u.z)});
  return largest;
}

double largest_movement(const Motion& motion, std::size_t thing) {
  float largest = 0;
  for (const MotionFrame& frame : motion.frames)
    for (const Vec3 u : frame.moved[thing]) largest = std::max(largest, norm(u));
  return largest;
}

const char* kind_name(MovingThing::Kind kind) {
  constexpr const char* kNames[] = {"body", "inside", "tool", "obstacle"};
  return kNames[std::size_t(kind)];
}

const char* look_name(Look look) {
  return look == Look::kSkin ? "skin" : look == Look::kCloth ? "cloth" : "flesh";
}

using Frames = std::vector<const MotionFrame*>;

/// Surfaces that no frame uses are null.
Json json_of(const Motion& motion, std::size_t t, const Frames& frames, double quantum) {
  const MovingThing& thing = motion.things[t];
  Json surfaces = Json::array();
  for (std::size_t s = 0; s < thing.surfaces.size(); s++) {
    const bool snapshot =
        std::any_of(frames.begin(), frames.end(), [&](const MotionFrame* f) { return f->surface[t] == s; });
    surfaces.push_back(snapshot ? json_of(thing.surfaces[s]) : Json());
  }
  return {{"kind", kind_name(thing.kind)},
          {"name", thing.name},
          {"look", look_name(thing.look)},
          {"quantum", quantum},
          {"largest_m", largest_movement(motion, t)},
          {"usual_force_N", thing.typical_force},
          {"surfaces", std::move(surfaces)}};
}

std::vector<std::int32_t> quantized(const std::vector<Vec3>& moved, double quantum) {
  std::vector<std::int32_t> numbers;
  numbers.reserve(3 * moved.size());
  for (int axis = 0; axis < 3; axis++)
    for (const Vec3 u : moved) numbers.push_back(std::int32_t(std::lround(double(u[axis]) / quantum)));
  return numbers;
}

Json json_of(const Frames& frames, const std::vector<double>& quanta) {
  Json list = Json::array();
  std::vector<std::vector<std::int32_t>> before(quanta.size());
  for (std::size_t f = 0; f < frames.size(); f++) {
    const MotionFrame& frame = *frames[f];
    Json things = Json::array(), forces = Json::array();
    for (std::size_t t = 0; t < quanta.size(); t++) {
      std::vector<std::int32_t> now = quantized(frame.moved[t], quanta[t]);
      std::vector<std::int32_t> change = now;
      if (f > 0 && frames[f - 1]->surface[t] == frame.surface[t])
        for (std::size_t i = 0; i < now.size(); i++) change[i] -= before[t][i];
      things.push_back({frame.surface[t], packed(change, kWord)});
      before[t] = std::move(now);
    }
    for (const MotionFrame::Force& force : frame.forces)
      forces.push_back({json_of(force.at), json_of(force.force)});
    list.push_back({{"time_s", frame.time}, {"things", std::move(things)}, {"forces_N", std::move(forces)}});
  }
  return list;
}

std::string color_map() {
  std::string bytes;
  for (int i = 0; i < 256; i++) {
    const Rgb c = map_color(float(i) / 255);
    for (const std::uint8_t channel : {c.r, c.g, c.b}) bytes += char(channel);
  }
  return io::base64(bytes);
}

/// Escapes '<', so that no name can end the enclosing script element.
std::string safe_in_script(std::string text) {
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string::npos;) text.replace(at, 1, "\\u003c");
  return text;
}

/// Every second frame, with the first and the last.
Frames every_other(const Frames& frames) {
  Frames kept;
  for (std::size_t f = 0; f < frames.size(); f++)
    if (f % 2 == 0 || f + 1 == frames.size()) kept.push_back(frames[f]);
  return kept;
}

}  // namespace

void add_moment(const WorldSnapshot& snapshot, Motion& motion, const MotionLimits& limits) {
  MotionFrame frame{.time = snapshot.time, .surface = {}, .moved = {}, .forces = {}};
  std::size_t at = 0;
  for (const BodySnapshot& body : snapshot.bodies)
    add_thing(thing_of_body(body), at++, limits.triangles, motion, frame);
  for (const BodySnapshot& body : snapshot.bodies)
    if (!body.inside.triangles.empty())
      add_thing(thing_of_inside(body), at++, limits.triangles, motion, frame);
  for (const ToolSnapshot& tool : snapshot.tools)
    add_thing(thing_of_tool(tool), at++, limits.triangles, motion, frame);
  for (const auto* meshes : {&snapshot.obstacles, &snapshot.threads})
    for (const TriMesh& mesh : *meshes)
      add_thing(thing_of_obstacle(mesh), at++, limits.triangles, motion, frame);
  for (const ToolSnapshot& tool : snapshot.tools) frame.forces.push_back({tool.pose.position, tool.force});
  if (!motion.frames.empty() && motion.frames.back().time == frame.time) {
    motion.numbers -= numbers_in(motion.frames.back());
    motion.frames.pop_back();
  }
  motion.numbers += numbers_in(frame);
  motion.frames.push_back(std::move(frame));
  while (motion.numbers > limits.numbers && motion.frames.size() > 2) thin(motion);
}

std::string motion_json(const Motion& motion, std::size_t bytes) {
  if (motion.frames.empty()) return {};
  std::vector<double> quanta;  // a difference of two displacements must also fit in 16 bits
  for (std::size_t t = 0; t < motion.things.size(); t++)
    quanta.push_back(std::max(largest_component(motion, t) / 16383, 1e-12));
  Frames frames;
  for (const MotionFrame& frame : motion.frames) frames.push_back(&frame);
  for (;; frames = every_other(frames)) {
    Json things = Json::array();
    for (std::size_t t = 0; t < quanta.size(); t++) things.push_back(json_of(motion, t, frames, quanta[t]));
    const Json all = {
        {"map", color_map()}, {"things", std::move(things)}, {"frames", json_of(frames, quanta)}};
    std::string text = safe_in_script(json_text(all, -1));
    if (text.size() <= bytes) return text;
    if (frames.size() <= 2) return {};
  }
}

}  // namespace turgor

// Bodies and tools by index, and copies of surfaces to the caller's buffers.
#include "c/buffer.hpp"
#include "c/sized.hpp"
#include "c/world.hpp"

namespace turgor::c {

BodyId id_of(const tg_world& world, std::int32_t index) {
  std::vector<BodyId> ids;
  for_each_body(*world.world, [&](BodyId id, const auto&) { ids.push_back(id); });
  expect(index >= 0 && std::size_t(index) < ids.size(),
         "expected the index of a body, found one out of range");
  return ids[std::size_t(index)];
}

namespace {

std::int32_t number_of(const tg_world& world, BodyId wanted) {
  std::int32_t number = 0, found = -1;
  for_each_body(*world.world, [&](BodyId id, const auto&) {
    if (id == wanted) found = number;
    number++;
  });
  return found;
}

const TouchingTool& tool_of(const tg_world& world, std::int32_t index) {
  expect(index >= 0 && std::size_t(index) < world.world->tools.size(),
         "expected the index of a tool, found one out of range");
  return world.world->tools[std::size_t(index)];
}

const BodySnapshot& current_snapshot(tg_world& world, std::int32_t index) {
  const BodyId id = id_of(world, index);
  if (!world.is_shown) show(world.exec, *world.world, world.snapshot);
  world.is_shown = true;
  return body_snapshot(world.snapshot, id);
}

/// Differs for different triangles of one world: a state that is read may have other cuts of the same number.
std::uint64_t topology_of(const tg_world& world, BodyId id) {
  if (id.kind != BodyKind::kLattice) return 0;
  return (world.replaced_cuts << 40) +
         lattice::cut_version(world.world->lattice_bodies[std::size_t(id.index)].state.cuts());
}

void copy_points(const std::vector<Vec3>& points, float* buffer, std::size_t capacity, std::size_t* written) {
  static_assert(sizeof(Vec3) == 3 * sizeof(float));
  copy_out(points.empty() ? nullptr : &points.data()->x, 3 * points.size(), buffer, capacity, written);
}

void read(const BodySnapshot& body, std::int32_t quantity, float* buffer, std::size_t capacity,
          std::size_t* count) {
  switch (quantity) {
    case TG_POINTS:
      return copy_points(body.x, buffer, capacity, count);
    case TG_REST:
      return copy_points(body.rest, buffer, capacity, count);
    case TG_DISPLACEMENT:
      return copy_points(body.displacement, buffer, capacity, count);
    case TG_NORMALS:
      return copy_points(body.normals, buffer, capacity, count);
    case TG_PRESSURE:
      return copy_out(body.pressure.data(), body.pressure.size(), buffer, capacity, count);
    case TG_STRETCH:
      return copy_out(body.stretch.data(), body.stretch.size(), buffer, capacity, count);
    default:
      throw Misuse("expected one of TG_POINTS … TG_STRETCH, found another number");
  }
}

}  // namespace
}  // namespace turgor::c

using namespace turgor;
using namespace turgor::c;

tg_status tg_body_find(tg_world* world, const char* name, int32_t* body) {
  return with(world, [=](tg_world& w) {
    expect(name && body, "expected a name and a pointer to an index, found null");
    *body = -1;
    for_each_body(*w.world, [&](BodyId id, const auto& one) {
      if (one.name == name) *body = number_of(w, id);
    });
    if (*body < 0) throw Refused(std::string("the scene has no body ") + name);
  });
}

tg_status tg_body_get_info(tg_world* world, int32_t body, tg_body_info* info) {
  return with(world, [=](tg_world& w) {
    const BodySnapshot& snapshot = current_snapshot(w, body);
    tg_body_info filled{};
    visit_body(*w.world, snapshot.id, [&](const auto& one) { filled.name = one.name.c_str(); });
    filled.model = model_name(snapshot.id.kind);
    filled.vertices = std::int32_t(snapshot.x.size()),
    filled.triangles = std::int32_t(snapshot.triangles.size());
    filled.topology_version = topology_of(w, snapshot.id);
    fill(filled, info);
  });
}

tg_status tg_body_read(tg_world* world, int32_t body, int32_t quantity, float* buffer, size_t capacity,
                       size_t* count) {
  return with(world,
              [=](tg_world& w) { read(current_snapshot(w, body), quantity, buffer, capacity, count); });
}

tg_status tg_body_triangles(tg_world* world, int32_t body, int32_t* buffer, size_t capacity, size_t* count) {
  return with(world, [=](tg_world& w) {
    static_assert(sizeof(Int3) == 3 * sizeof(std::int32_t));
    const std::vector<Int3>& triangles = current_snapshot(w, body).triangles;
    copy_out(triangles.empty() ? nullptr : &triangles.data()->x, 3 * triangles.size(), buffer, capacity,
             count);
  });
}

tg_status tg_tool_find(tg_world* world, const char* name, int32_t* tool) {
  return with(world, [=](tg_world& w) {
    expect(name && tool, "expected a name and a pointer to an index, found null");
    *tool = -1;
    for (std::size_t t = 0; t < w.world->tools.size(); t++)
      if (w.world->tools[t].name == name) *tool = std::int32_t(t);
    if (*tool < 0) throw Refused(std::string("the scene has no tool ") + name);
  });
}

tg_status tg_tool_get_info(tg_world* world, int32_t tool, tg_tool_info* info) {
  return with(world, [=](tg_world& w) {
    const TouchingTool& one = tool_of(w, tool);
    tg_tool_info filled{};
    filled.name = one.name.c_str(), filled.body = number_of(w, one.body);
    fill(filled, info);
  });
}

tg_status tg_tool_get_command(tg_world* world, int32_t tool, tg_command* command) {
  return with(world, [=](tg_world& w) {
    expect(command != nullptr, "expected a pointer to a command, found null");
    const TouchingTool& one = tool_of(w, tool);
    const double time = time_of(*w.world);
    const contact::ToolCommand now =
        w.driven ? path_command(*w.driven, std::size_t(tool), time) : command_at(one, time);
    const PathRow row = path_of({{0, now}}).rows[0];
    *command = {{row.position.x, row.position.y, row.position.z},
                {row.orientation[0], row.orientation[1], row.orientation[2], row.orientation[3]},
                now.hold ? 1 : 0,
                0};
  });
}

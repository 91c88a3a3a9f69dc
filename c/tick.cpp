// Ticks of tools: alternating with frames on one thread, or on a haptic thread.
#include <cmath>

#include "c/sized.hpp"
#include "c/world.hpp"
#include "turgor/geometry/quaternion.hpp"

namespace turgor::c {

namespace {

contact::ToolCommand command_of(const tg_command& given) {
  Quaternion orientation;
  std::copy_n(given.orientation, 4, orientation.begin());
  const double length = std::sqrt(dot(orientation, orientation));
  bool finite = std::isfinite(length) && length > 0;
  for (const double x : given.position) finite = finite && std::isfinite(x);
  expect(finite, "expected a position of finite numbers and an orientation that is not 0");
  return {
      .pose = {{given.position[0], given.position[1], given.position[2]}, axes_of(normalized(orientation))},
      .hold = given.hold != 0};
}

tg_reading reading_of(const contact::ToolReading& haptic) {
  return {{haptic.force.x, haptic.force.y, haptic.force.z},
          {haptic.torque.x, haptic.torque.y, haptic.torque.z},
          haptic.depth,
          haptic.age,
          haptic.contacts,
          haptic.beyond_patch ? 1 : 0};
}

/// Arrays of the caller, whose elements may be of an older or a newer header.
struct Arrays {
  const tg_command* commands;
  std::size_t command_size;
  tg_reading* readings;
  std::size_t reading_size;
};

void check(const tg_world& world, const Arrays& arrays) {
  const bool any = !world.commands.empty();
  expect(!any || (arrays.commands && arrays.readings),
         "expected commands and readings of all tools, found null");
  expect(arrays.command_size >= 7 * sizeof(double) && arrays.reading_size >= 6 * sizeof(double),
         "expected sizeof(tg_command) and sizeof(tg_reading)");
}

void take(tg_world& world, const Arrays& arrays, std::size_t first) {
  for (std::size_t t = 0; t < world.commands.size(); t++)
    world.commands[t] = command_of(element_of(arrays.commands, arrays.command_size, first + t));
}
void put(const tg_world& world, const Arrays& arrays, std::size_t first) {
  for (std::size_t t = 0; t < world.readings.size(); t++)
    put_element(reading_of(world.readings[t]), arrays.readings, arrays.reading_size, first + t);
}

}  // namespace
}  // namespace turgor::c

using namespace turgor;
using namespace turgor::c;

tg_status tg_world_tick(tg_world* world, const tg_command* commands, size_t command_size,
                        tg_reading* readings, size_t reading_size, size_t ticks) {
  return with(world, [=](tg_world& w) {
    expect_unended(w);
    expect(!w.touched, "expected a world without haptic thread, found one with an earlier tg_touch_begin");
    const Arrays arrays{commands, command_size, readings, reading_size};
    check(w, arrays);
    if (!w.driven) w.driven = begin_driven(*w.world);
    w.is_shown = false;
    for (std::size_t n = 0; n < ticks; n++) {
      take(w, arrays, n * w.commands.size());
      const Status done = tick_driven(w.exec, *w.world, *w.driven, w.commands, w.readings);
      if (!done) throw Refused(done.error().message);
      put(w, arrays, n * w.readings.size());
    }
  });
}

tg_status tg_touch_begin(tg_world* world) {
  return with(world, [](tg_world& w) {
    expect_unended(w);
    expect(!w.driven, "expected a world without ticks, found one with earlier ticks");
    w.driven = begin_driven(*w.world);
    w.touched = w.was_touched = true;
  });
}

tg_status tg_touch_tick(tg_world* world, const tg_command* commands, size_t command_size,
                        tg_reading* readings, size_t reading_size) {
  return with(world, &tg_world::is_ticked, [=](tg_world& w) {
    expect(w.touched, "expected tg_touch_tick after tg_touch_begin, found a world without it");
    const Arrays arrays{commands, command_size, readings, reading_size};
    check(w, arrays);
    take(w, arrays, 0);
    tick_tools(*w.world, *w.driven, w.commands, w.readings);
    put(w, arrays, 0);
  });
}

tg_status tg_touch_end(tg_world* world) {
  return with(world, [](tg_world& w) {
    const Entered ticks(w.is_ticked);
    expect(w.touched, "expected tg_touch_end after tg_touch_begin, found a world without it");
    end_driven(*w.world);
    w.touched = false;
  });
}

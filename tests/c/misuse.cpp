// Errors of the C interface: wrong scenes, null and random arguments, short buffers.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <new>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <turgor.h>

#include "c/guard.hpp"
#include "tests/c/owned_world.hpp"
#include "turgor/core/assert.hpp"
#include "turgor/core/plain_text.hpp"

namespace turgor {
namespace {

using test::def_of;
using test::finger_at;
using test::kPad;
using test::OwnedWorld;

// Errors of a scene are reported as a message; the next success clears it.
TEST(CMisuse, SceneErrorsHaveMessage) {
  tg_world* world = nullptr;
  tg_world_def def = def_of("[body.pad]\nmodel = \"jelly\"\n");
  EXPECT_EQ(tg_world_create(&def, &world), TG_ERROR);
  EXPECT_EQ(world, nullptr);
  EXPECT_NE(std::string(tg_error()).find("jelly"), std::string::npos);
  def = def_of(kPad);
  def.scene = "also.toml";
  EXPECT_EQ(tg_world_create(&def, &world), TG_MISUSE);
  EXPECT_STRNE(tg_error(), "");
  EXPECT_EQ(tg_world_destroy(nullptr), TG_OK);
  EXPECT_STREQ(tg_error(), "");
}

// Null arguments of every function are errors and never crash.
TEST(CMisuse, NullArgumentsAreErrors) {
  tg_world* none = nullptr;
  EXPECT_NE(tg_default_world_def(nullptr, sizeof(tg_world_def)), TG_OK);
  EXPECT_NE(tg_world_create(nullptr, nullptr), TG_OK);
  EXPECT_NE(tg_world_create(nullptr, &none), TG_OK);
  const OwnedWorld owned(kPad);
  for (tg_world* world : {none, owned.world}) {
    EXPECT_NE(tg_world_copy(world, nullptr), TG_OK);
    EXPECT_NE(tg_world_get_info(world, nullptr), TG_OK);
    EXPECT_NE(tg_world_state_hash(world, nullptr), TG_OK);
    EXPECT_NE(tg_world_step(world, -1), TG_OK);
    EXPECT_NE(tg_body_find(world, nullptr, nullptr), TG_OK);
    EXPECT_NE(tg_body_get_info(world, 0, nullptr), TG_OK);
    EXPECT_NE(tg_body_read(world, 0, TG_POINTS, nullptr, 1000000, nullptr), TG_OK);
    EXPECT_NE(tg_body_triangles(world, 0, nullptr, 1000000, nullptr), TG_OK);
    EXPECT_NE(tg_tool_find(world, nullptr, nullptr), TG_OK);
    EXPECT_NE(tg_tool_get_info(world, 0, nullptr), TG_OK);
    EXPECT_NE(tg_tool_get_command(world, 0, nullptr), TG_OK);
    EXPECT_NE(tg_touch_tick(world, nullptr, sizeof(tg_command), nullptr, sizeof(tg_reading)), TG_OK);
    EXPECT_NE(tg_touch_end(world), TG_OK);
    EXPECT_NE(tg_world_tick(world, nullptr, sizeof(tg_command), nullptr, sizeof(tg_reading), 1), TG_OK);
  }
  EXPECT_NE(tg_touch_begin(none), TG_OK);
}

// Random arguments, including values outside of the enums, never crash.
TEST(CMisuse, RandomArgumentsNeverCrash) {
  const OwnedWorld owned(kPad);
  std::mt19937 random(1);
  const auto number = [&random] { return std::int32_t(random() % 9) - 3; };
  std::array<float, 16> few{};
  std::array<std::int32_t, 16> corners{};
  for (int n = 0; n < 2000; n++) {
    tg_world* world = random() % 8 ? owned.world : nullptr;
    std::size_t count = 0;
    float* floats = random() % 2 ? few.data() : nullptr;
    std::int32_t* ints = random() % 2 ? corners.data() : nullptr;
    tg_body_info body{random() % 2 ? sizeof(tg_body_info) : random() % 64, nullptr, nullptr, 0, 0, 0};
    tg_tool_info tool{random() % 2 ? sizeof(tg_tool_info) : random() % 16, nullptr, 0};
    EXPECT_NE(tg_body_read(world, number(), number(), floats, floats ? few.size() : 0,
                           random() % 2 ? &count : nullptr),
              TG_BROKEN);
    EXPECT_NE(tg_body_triangles(world, number(), ints, ints ? corners.size() : 0, nullptr), TG_BROKEN);
    EXPECT_NE(tg_body_get_info(world, number(), &body), TG_BROKEN) << tg_error();
    EXPECT_NE(tg_tool_get_info(world, number(), &tool), TG_BROKEN) << tg_error();
    EXPECT_NE(tg_body_find(world, random() % 2 ? "pad" : "liver", random() % 2 ? ints : nullptr), TG_BROKEN);
    tg_command command = finger_at(random() % 2 ? 0.035 : NAN);
    command.orientation[0] = random() % 3 ? 2 : 0;
    tg_reading reading;
    const std::size_t size = random() % 2 ? sizeof command : random() % 56;
    EXPECT_NE(tg_world_tick(world, random() % 4 ? &command : nullptr, size, &reading, sizeof reading, 1),
              TG_BROKEN)
        << tg_error();
  }
}

// A buffer that is too short is an error and is not written.
TEST(CMisuse, ShortBufferIsNotWritten) {
  const OwnedWorld c(kPad);
  std::size_t count = 0;
  EXPECT_EQ(tg_body_read(c.world, 0, TG_REST, nullptr, 0, &count), TG_MISUSE);
  std::vector<float> buffer(count, 7);
  EXPECT_EQ(tg_body_read(c.world, 0, TG_REST, buffer.data(), count - 1, nullptr), TG_MISUSE);
  EXPECT_EQ(buffer, std::vector<float>(count, 7));
  EXPECT_EQ(tg_body_read(c.world, 0, TG_REST, buffer.data(), count, nullptr), TG_OK) << tg_error();
  EXPECT_NEAR(*std::max_element(buffer.begin(), buffer.end()), 0.06, 1e-6);
}

// A number of threads that no machine has is the caller's error, not a crash.
TEST(CMisuse, RejectsThreadsOutOfRange) {
  for (const std::int32_t threads : {-1, 1025, 5000, 2147483647}) {
    tg_world_def def = def_of(kPad);
    def.threads = threads;
    tg_world* world = nullptr;
    EXPECT_EQ(tg_world_create(&def, &world), TG_MISUSE);
    EXPECT_EQ(world, nullptr);
    EXPECT_EQ(std::string(tg_error()),
              fmt::format("expected a number of threads from 0 (one per core) to 1024, found {}", threads));
  }
}

// A size that no struct has is the caller's error, and nothing is written.
TEST(CMisuse, RejectsSizesThatNoStructHas) {
  for (const std::size_t size :
       {std::size_t(0), std::size_t(7), std::size_t(1) << 16, std::size_t(1) << 18}) {
    std::vector<std::uint64_t> memory(std::size_t(1) << 15, 9);
    void* const any = memory.data();
    EXPECT_EQ(tg_default_world_def(static_cast<tg_world_def*>(any), size), TG_MISUSE) << size;
    EXPECT_EQ(tg_default_cut(static_cast<tg_cut*>(any), size), TG_MISUSE) << size;
    EXPECT_EQ(tg_default_stitch(static_cast<tg_stitch*>(any), size), TG_MISUSE) << size;
    EXPECT_EQ(memory, std::vector<std::uint64_t>(std::size_t(1) << 15, 9)) << size;
  }
}

// A message that is too long for its buffer ends with a whole character.
TEST(CGuard, LongMessageEndsWithWholeCharacter) {
  for (std::size_t before = 2040; before < 2050; before++) {
    c::guarded([&] { throw c::Refused(std::string(before, 'a') + "é€𝛼"); });
    const std::string message = c::current_error();
    EXPECT_EQ(plain_text(message), message) << before;
    EXPECT_GE(message.size(), std::min<std::size_t>(before, 2040)) << before;
  }
}

// Failed assertions and exceptions become status codes with a message.
TEST(CGuard, MapsExceptionsToStatus) {
  EXPECT_EQ(c::guarded([] { TURGOR_ASSERT(1 < 0, "one is less than none"); }), TG_BROKEN);
  EXPECT_NE(std::string(c::current_error()).find("one is less than none"), std::string::npos);
  EXPECT_EQ(c::guarded([] { throw std::bad_alloc(); }), TG_NO_MEMORY);
  EXPECT_EQ(c::guarded([] { throw 7; }), TG_BROKEN);
  EXPECT_EQ(c::guarded([] {}), TG_OK);
  EXPECT_STREQ(c::current_error(), "");
}

}  // namespace
}  // namespace turgor

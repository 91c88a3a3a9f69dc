// Any bytes as what the Inverse Service says: what is taken is finite numbers, what is not leaves all as it
// was, never a crash. What is said of an arm with any name is JSON.
#include <cmath>
#include <cstdint>
#include <string>

#include "fuzz_input.hpp"
#include "turgor/haptics/drivers/inverse3_messages.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace turgor::haptics;
  const nlohmann::json message = parse_message(std::string(reinterpret_cast<const char*>(bytes), size));
  const turgor::Vec3d expected{1, 2, 3};
  Inverse3Arm arm{.position = expected};
  const bool is_read = read_arm(message, "049D", arm);
  require(is_read || arm.position == expected);
  for (int axis = 0; axis < 3; axis++)
    require(std::isfinite(arm.position[axis]) && std::isfinite(arm.velocity[axis]));
  require(std::abs(turgor::dot(arm.orientation, arm.orientation) - 1) < 1e-6);
  for (const std::string& id : arm_ids(message)) {
    require(parse_message(force_command(id, {0.1, -2, 1e-7})).is_object());
    require(parse_message(configuring_command(id, true)).is_object());
  }
  return 0;
}

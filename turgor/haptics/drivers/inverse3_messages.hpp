// JSON messages to and from the Haply Inverse Service (docs.haply.co/inverseSDK, 3.1 to 3.5). Meters, meters
// a second, newtons; +x right, +y away from the user, +z up, as in the device frame.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "turgor/core/vec.hpp"
#include "turgor/geometry/quaternion.hpp"

namespace turgor::haptics {

/// State of an arm and its grip. Fields that a message omits keep their values, except the velocity, which
/// becomes zero.
struct Inverse3Arm {
  std::string type = "inverse3";  // or inverse3x, minverse
  bool is_allocated = false;      // the last message contains it
  bool is_calibrated = false;
  Vec3d position, velocity;  // of the cursor [m] [m/s]
  bool has_grip = false;
  Quaternion orientation{1, 0, 0, 0};  // of the grip, unit
  std::uint32_t buttons = 0;           // in alphabetical order, a bit each
};

/// Parses a message of the service. The result is discarded when it is not a JSON object.
nlohmann::json parse_message(const std::string& text);
/// Ids of the arms in a message.
std::vector<std::string> arm_ids(const nlohmann::json& message);
/// Updates an arm from a message. Returns false and keeps `arm` when a field violates the documentation or an
/// arm lacks its position.
bool read_arm(const nlohmann::json& message, const std::string& id, Inverse3Arm& arm);

/// Command that requests the full state of all arms.
std::string full_state_command();
/// Command that sets frame and origin (the middle of the workspace) and zero force; sent once, before other
/// commands. `with_session` adds the settings of the session, once a connection.
std::string configuring_command(const std::string& id, bool with_session);
/// Command that requests the arm's state only.
std::string probing_command(const std::string& id);
/// Command with a force on the hand [N], in both spellings that versions of the service accept: `vector` and
/// `values`.
std::string force_command(const std::string& id, Vec3d force);

}  // namespace turgor::haptics

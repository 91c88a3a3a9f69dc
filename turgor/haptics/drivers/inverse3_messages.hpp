// What is said to the Haply Inverse Service and what it says, as JSON (docs.haply.co/inverseSDK, 3.1 to 3.5).
// Metres, metres a second, newtons; +x right, +y away from the user, +z up: as our own frame.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "turgor/core/vec.hpp"
#include "turgor/geometry/quaternion.hpp"

namespace turgor::haptics {

/// What is known of an arm and the grip on it. What a message leaves out stays as it was, but a velocity,
/// which is zero then.
struct Inverse3Arm {
  std::string type = "inverse3";  // or inverse3x, minverse
  bool is_allocated = false;      // the last message tells of it
  bool is_calibrated = false;
  Vec3d position, velocity;  // of the cursor [m] [m/s]
  bool has_grip = false;
  Quaternion orientation{1, 0, 0, 0};  // of the grip, unit
  std::uint32_t buttons = 0;           // its buttons in alphabetical order, a bit each
};

/// A message of the service; discarded when it is no JSON object.
nlohmann::json parse_message(const std::string& text);
/// Of the arms in a message.
std::vector<std::string> arm_ids(const nlohmann::json& message);
/// Takes what a message says of an arm. False, and `arm` is as it was: a field is not what the documents
/// say, or an arm that is there does not say where it is.
bool read_arm(const nlohmann::json& message, const std::string& id, Inverse3Arm& arm);

/// Asks for everything about all arms.
std::string ask_for_all();
/// Chooses frame and origin (the middle of the workspace) and holds no force: once, before other commands.
/// `with_session`: also what is said once a connection.
std::string configuring_command(const std::string& id, bool with_session);
/// Asks for the arm's state alone.
std::string probing_command(const std::string& id);
/// A force on the hand [N], in both spellings that versions of the service read: `vector` and `values`.
std::string force_command(const std::string& id, Vec3d force);

}  // namespace turgor::haptics

#include "turgor/haptics/drivers/inverse3_messages.hpp"

#include <cmath>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"

namespace turgor::haptics {

using Json = nlohmann::json;

namespace {

const Json kNothing;  // null

/// Member of an object, or null.
const Json& member(const Json& object, const char* key) {
  const auto found = object.is_object() ? object.find(key) : object.end();
  return found == object.end() ? kNothing : *found;
}

/// Reads numbers. Omitted members keep their values. False when a value is not a finite number.
bool read_numbers(const Json& object, std::initializer_list<std::pair<const char*, double*>> members) {
  if (!object.is_object()) return false;
  for (const auto& [key, value] : members) {
    const Json& number = member(object, key);
    if (&number == &kNothing) continue;  // omitted
    if (!number.is_number() || !std::isfinite(number.get<double>())) return false;
    *value = number.get<double>();
  }
  return true;
}

bool read_vector(const Json& object, Vec3d& v) {
  v = {};
  return read_numbers(object, {{"x", &v.x}, {"y", &v.y}, {"z", &v.z}});
}

bool read_orientation(const Json& object, Quaternion& orientation) {
  Quaternion q{1, 0, 0, 0};
  if (!read_numbers(object, {{"w", &q[0]}, {"x", &q[1]}, {"y", &q[2]}, {"z", &q[3]}})) return false;
  if (std::abs(dot(q, q) - 1) > 0.05) return false;
  orientation = normalized(q);
  return true;
}

/// Element of a list with this id, or the first one when `id` is empty; null when not found.
const Json& element(const Json& list, const std::string& id) {
  if (list.is_array())
    for (const Json& one : list)
      if (id.empty() || member(one, "device_id") == id) return one;
  return kNothing;
}

/// Buttons of a grip: a single `button` for the wired grip, a list `buttons` for the wireless one.
std::uint32_t buttons_of(const Json& state) {
  std::uint32_t buttons = member(state, "button") == true ? 1u : 0u;
  std::uint32_t bit = 1;
  const Json& named = member(state, "buttons");
  if (!named.is_object()) return buttons;
  for (const Json& is_down : named) {
    if (is_down == true) buttons |= bit;
    bit <<= 1;
  }
  return buttons;
}

/// Reads the first grip that has a state. False when it violates the documentation.
bool read_grip(const Json& message, Inverse3Arm& arm) {
  for (const char* kind : {"wireless_verse_grip", "verse_grip"}) {
    const Json& state = member(element(member(message, kind), ""), "state");
    if (!state.is_object()) continue;
    const Json& orientation = member(state, "orientation");
    if (!orientation.is_null() && !read_orientation(orientation, arm.orientation)) return false;
    arm.has_grip = true;
    arm.buttons = buttons_of(state);
    return true;
  }
  return true;
}

/// Text as a JSON string.
std::string quoted(const std::string& text) {
  return Json(text).dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

Json parse_message(const std::string& text) {
  Json message = Json::parse(text, nullptr, false);
  return message.is_object() ? message : Json(Json::value_t::discarded);
}

std::vector<std::string> arm_ids(const Json& message) {
  std::vector<std::string> ids;
  const Json& arms = member(message, "inverse3");
  if (!arms.is_array()) return ids;
  for (const Json& arm : arms)
    if (const Json& id = member(arm, "device_id"); id.is_string()) ids.push_back(id.get<std::string>());
  return ids;
}

bool read_arm(const Json& message, const std::string& id, Inverse3Arm& arm) {
  if (!message.is_object()) return false;
  // state of the arm
  Inverse3Arm reported = arm;
  const Json& arm_state = element(member(message, "inverse3"), id);
  reported.is_allocated = arm_state.is_object();
  if (reported.is_allocated) {
    const Json& state = member(arm_state, "state");
    const Json& velocity = member(state, "cursor_velocity");
    if (!read_vector(member(state, "cursor_position"), reported.position)) return false;
    reported.velocity = {};
    if (!velocity.is_null() && !read_vector(velocity, reported.velocity)) return false;
    const Json& calibrated = member(member(arm_state, "status"), "calibrated");
    if (calibrated.is_boolean()) reported.is_calibrated = calibrated.get<bool>();
    const Json& type = member(member(arm_state, "config"), "type");
    if (type.is_string()) reported.type = type.get<std::string>();
  }
  // state of the grip
  if (!read_grip(message, reported)) return false;
  arm = reported;
  return true;
}

std::string full_state_command() { return R"({"session":{"force_render_full_state":{}}})"; }

std::string configuring_command(const std::string& id, bool with_session) {
  constexpr const char* kSession =
      R"("session":{"configure":{"profile":{"name":"org.turgor:touch"},"basis":{"permutation":"XYZ"}}},)";
  return fmt::format(
      R"({{{}"inverse3":[{{"device_id":{},"configure":{{"preset":{{"preset":"arm_front_centered"}}}},)"
      R"("commands":{{"set_cursor_force":{{"vector":{{"x":0,"y":0,"z":0}},"values":{{"x":0,"y":0,"z":0}}}}}}}}]}})",
      with_session ? kSession : "", quoted(id));
}

std::string probing_command(const std::string& id) {
  return fmt::format(R"({{"inverse3":[{{"device_id":{},"commands":{{"probe_position":{{}}}}}}]}})",
                     quoted(id));
}

std::string force_command(const std::string& id, Vec3d force) {
  TURGOR_CHECK(std::isfinite(dot(force, force)), "forces are finite before they go to a device");
  const std::string vector = fmt::format(R"({{"x":{},"y":{},"z":{}}})", force.x, force.y, force.z);
  return fmt::format(
      R"({{"inverse3":[{{"device_id":{},"commands":{{"set_cursor_force":{{"vector":{},"values":{}}}}}}}]}})",
      quoted(id), vector, vector);
}

}  // namespace turgor::haptics

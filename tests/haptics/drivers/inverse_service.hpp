// Replacement of Haply's Inverse Service: a WebSocket server with the documented JSON protocol. Tests move
// its arms and make it misbehave.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "turgor/core/vec.hpp"

namespace turgor::test {

enum class Behavior {
  kGood,
  kGarbage,     // answers that are no JSON
  kNoNumber,    // a position that is not a number
  kHuge,        // a position one kilometer away
  kOtherTypes,  // JSON of types that contradict the documentation
  kOmitting,    // omits all optional fields
  kLate,        // answers after 60 ms
  kSilent,      // does not answer
  kBrokenText,  // answers that are no UTF-8, which ends the connection
  kHangsUp,     // ends the connection in the middle of a conversation
};

class InverseService {
 public:
  /// `force_key`: the spelling of the force command that the service accepts; unknown keys are ignored.
  explicit InverseService(std::string force_key = "vector");
  ~InverseService();
  std::string address() const;

  void set_behavior(Behavior behavior);
  /// Sets the identifiers of the connected arms.
  void set_arms(std::vector<std::string> ids);
  void set_calibrated(bool is_calibrated);
  void set_hand(Vec3d position, Vec3d velocity);
  /// Sets the state of a wireless_verse_grip, or of a verse_grip (with one button).
  void set_grip(const std::string& kind, const nlohmann::json& state);

  Vec3d force() const;                           // last force at the first arm [N]
  std::vector<nlohmann::json> received() const;  // all messages since the start
  int unanswered() const;                        // commands that arrived before the previous one was answered
  int connections() const;

 private:
  struct Server;
  std::unique_ptr<Server> server_;
};

}  // namespace turgor::test

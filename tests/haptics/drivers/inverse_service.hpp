// In place of Haply's Inverse Service: a WebSocket server that speaks the JSON of its documents, around arms
// that a test moves, and that misbehaves as it is told.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "turgor/core/vec.hpp"

namespace turgor::test {

enum class Manner {
  kGood,
  kGarbage,     // answers that are no JSON
  kNoNumber,    // a place that is no number
  kHuge,        // a place a kilometre away
  kOtherTypes,  // JSON of other types than the documents say
  kOmitting,    // all that may be left out is left out
  kLate,        // answers after 60 ms
  kSilent,      // does not answer
  kBrokenText,  // answers that are no UTF-8, which ends a connection
  kHangsUp,     // ends the connection in the middle of a conversation
};

class InverseService {
 public:
  /// Which spelling of a force it knows; it ignores others, as it ignores all that it does not know.
  explicit InverseService(std::string force_key = "vector");
  ~InverseService();
  std::string address() const;

  void set_manner(Manner manner);
  /// With an id each; an arm is calibrated or not.
  void set_arms(std::vector<std::string> ids);
  void set_calibrated(bool is_calibrated);
  void set_hand(Vec3d position, Vec3d velocity);
  /// A state of a wireless_verse_grip, or of a verse_grip (which has one button).
  void set_grip(const std::string& kind, const nlohmann::json& state);

  Vec3d force() const;                        // last felt by the first arm [N]
  std::vector<nlohmann::json> heard() const;  // all messages, from the first on
  int unanswered() const;                     // commands that came before the last one was answered
  int connections() const;

 private:
  struct Server;
  std::unique_ptr<Server> server_;
};

}  // namespace turgor::test

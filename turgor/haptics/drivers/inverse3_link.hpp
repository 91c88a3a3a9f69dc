// The conversation with the Inverse Service: a snapshot of everything first, then one answer a command. Knows
// nothing of threads; every call has an end.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/haptics/drivers/inverse3_messages.hpp"
#include "turgor/haptics/drivers/web_socket.hpp"

namespace turgor::haptics {

class Inverse3Link {
 public:
  /// `which`: the id of an arm; empty = the only one.
  Inverse3Link(std::string address, std::string which)
      : address_(std::move(address)), which_(std::move(which)) {}

  /// Within two seconds, or when `stops` becomes true. Error: nothing answers there, and what to install.
  Status connect(const std::atomic<bool>& stops);
  bool is_connected() const { return socket_ != nullptr; }
  /// Says one command and hears its answer: a force on a calibrated arm [N], else questions. An answer that
  /// is no use is none of an error: see is_understood. Error: the connection is lost, and is closed.
  Status talk(Vec3d force, const std::atomic<bool>& stops);
  /// The arm lets go, the connection is closed. Within 0.3 s.
  void say_goodbye() noexcept;

  /// The last answer made sense.
  bool is_understood() const { return is_understood_; }
  const Inverse3Arm& arm() const { return arm_; }
  const std::string& id() const { return id_; }  // of the arm; empty while it is not chosen
  /// Of all arms in the last answer.
  const std::vector<std::string>& ids() const { return ids_; }

 private:
  std::string next_command(Vec3d force);
  Status await_answer(const std::atomic<bool>& stops);
  void hear(const std::string& answer);

  std::string address_, which_, id_;
  std::unique_ptr<WebSocket> socket_;
  Inverse3Arm arm_;
  std::vector<std::string> ids_;
  bool is_understood_ = false, session_is_told_ = false, arm_is_configured_ = false;
};

/// Ids in a sentence.
std::string listed(const std::vector<std::string>& ids);

}  // namespace turgor::haptics

// Protocol of the Inverse Service: first a full snapshot, then one answer for each command. Contains no
// threads. Every call has a time limit.
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

  /// Connects within two seconds, or returns when `stop_requested` becomes true. Error: no answer from the
  /// service, and what to install.
  Status connect(const std::atomic<bool>& stop_requested);
  bool is_connected() const { return socket_ != nullptr; }
  /// Sends one command and receives its answer: a force for a calibrated arm [N], otherwise a query. An
  /// invalid answer is not an error: see is_understood. Error: the connection is lost and closed.
  Status exchange_message(Vec3d force, const std::atomic<bool>& stop_requested);
  /// Sets the arm's force to zero and closes the connection. Takes at most 0.3 s.
  void disconnect() noexcept;

  /// True when the last answer was valid.
  bool is_understood() const { return is_understood_; }
  const Inverse3Arm& arm() const { return arm_; }
  const std::string& id() const { return id_; }  // of the arm; empty while none is chosen
  /// Ids of all arms in the last answer.
  const std::vector<std::string>& ids() const { return ids_; }

 private:
  std::string next_command(Vec3d force);
  Status await_answer(const std::atomic<bool>& stop_requested);
  void parse_answer(const std::string& answer);

  std::string address_, which_, id_;
  std::unique_ptr<WebSocket> socket_;
  Inverse3Arm arm_;
  std::vector<std::string> ids_;
  bool is_understood_ = false, session_is_configured_ = false, arm_is_configured_ = false;
};

/// Ids as text, separated by commas.
std::string listed(const std::vector<std::string>& ids);

}  // namespace turgor::haptics

// WebSocket client with time limits: text messages over TCP, each sent at once.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "turgor/core/result.hpp"

namespace turgor::haptics {

/// Used by one thread at a time. Limits are in seconds.
class WebSocket {
 public:
  /// Connects to an `address` "HOST:PORT". Error: an invalid address, or the reason why no connection was
  /// made within `limit`.
  static Result<std::unique_ptr<WebSocket>> connect(const std::string& address, double limit);
  ~WebSocket();

  /// Error: the connection is lost, or the message was not sent within `limit`.
  Status send(const std::string& message, double limit);
  /// Receives a message. Empty when none came within `limit`; a later call may still receive it. Error: the
  /// connection is lost.
  Result<std::optional<std::string>> receive(double limit);
  /// Closes the connection with the closing handshake, if that takes at most `limit`.
  void close(double limit) noexcept;

 private:
  struct Connection;
  explicit WebSocket(std::unique_ptr<Connection> connection);
  std::unique_ptr<Connection> connection_;
};

}  // namespace turgor::haptics

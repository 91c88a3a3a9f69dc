// A WebSocket client that never waits longer than it is told to: text messages over TCP, each sent at once.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "turgor/core/result.hpp"

namespace turgor::haptics {

/// Used by one thread at a time. Limits are in seconds.
class WebSocket {
 public:
  /// `address` is "HOST:PORT". Error: what is wrong with it, or why nobody answers there within `limit`.
  static Result<std::unique_ptr<WebSocket>> connect(const std::string& address, double limit);
  ~WebSocket();

  /// Error: the connection is gone, or the message was not taken within `limit`.
  Status send(const std::string& message, double limit);
  /// Nothing: none came within `limit`, which a later call may still receive. Error: the connection is gone.
  Result<std::optional<std::string>> receive(double limit);
  /// Says goodbye and hears it, if that takes no longer than `limit`.
  void close(double limit) noexcept;

 private:
  struct Connection;
  explicit WebSocket(std::unique_ptr<Connection> connection);
  std::unique_ptr<Connection> connection_;
};

}  // namespace turgor::haptics

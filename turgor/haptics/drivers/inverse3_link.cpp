#include "turgor/haptics/drivers/inverse3_link.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/plain_text.hpp"
#include "turgor/core/timing.hpp"

namespace turgor::haptics {

namespace {

constexpr double kConnecting = 0.5;  // to a service on this machine [s]
constexpr double kSending = 0.1;     // [s]
constexpr double kSilence = 1;       // time without an answer after which the connection is closed [s]
constexpr double kListening = 0.05;  // between two checks of stop_requested [s]
constexpr double kGoodbye = 0.1;     // [s]

}  // namespace

std::string listed(const std::vector<std::string>& ids) {
  return on_one_line(fmt::format("{}", fmt::join(ids, ", ")));
}

Status Inverse3Link::connect(const std::atomic<bool>& stop_requested) {
  session_is_configured_ = arm_is_configured_ = is_understood_ = false;
  Result<std::unique_ptr<WebSocket>> socket = WebSocket::connect(address_, kConnecting);
  if (!socket)
    return Error{fmt::format("{}; install and start the Haply Inverse Service (docs/devices.md)",
                             socket.error().message)};
  socket_ = std::move(*socket);
  return await_answer(stop_requested);  // the service sends the first message
}

Status Inverse3Link::exchange_message(Vec3d force, const std::atomic<bool>& stop_requested) {
  TURGOR_ASSERT(socket_ != nullptr, "a message needs a connection");
  if (Status sent = socket_->send(next_command(force), kSending); !sent) return socket_.reset(), sent;
  return await_answer(stop_requested);
}

/// Next command. The first command of a connection, and the first one after an arm returns, also configures.
std::string Inverse3Link::next_command(Vec3d force) {
  arm_is_configured_ = arm_is_configured_ && arm_.is_allocated;
  if (!arm_.is_allocated) return full_state_command();
  TURGOR_CHECK(!id_.empty(), "an arm that answers has an id");
  if (!arm_is_configured_) {
    arm_is_configured_ = true;
    return configuring_command(id_, !std::exchange(session_is_configured_, true));
  }
  return arm_.is_calibrated ? force_command(id_, force) : probing_command(id_);
}

Status Inverse3Link::await_answer(const std::atomic<bool>& stop_requested) {
  TURGOR_ASSERT(socket_ != nullptr, "an answer needs a connection");
  const Timer silence;
  while (!stop_requested) {
    Result<std::optional<std::string>> answer = socket_->receive(kListening);
    if (!answer) return socket_.reset(), answer.error();
    if (*answer) return parse_answer(**answer), Done{};
    if (silence.seconds() < kSilence) continue;
    socket_.reset();
    return Error{fmt::format("{}: no answer for {:g} s", address_, kSilence)};
  }
  return Done{};
}

void Inverse3Link::parse_answer(const std::string& answer) {
  const nlohmann::json message = parse_message(answer);
  ids_ = arm_ids(message);
  if (id_.empty() && which_.empty() && ids_.size() == 1) id_ = ids_[0];
  if (id_.empty() && std::find(ids_.begin(), ids_.end(), which_) != ids_.end()) id_ = which_;
  is_understood_ = message.is_object() && (id_.empty() || read_arm(message, id_, arm_));
}

void Inverse3Link::disconnect() noexcept {
  if (!socket_) return;
  try {
    if (arm_.is_allocated && socket_->send(force_command(id_, {}), kGoodbye))
      (void)socket_->receive(kGoodbye);
  } catch (...) {  // no memory: the connection is closed in any case, and the arm's force ends
  }
  socket_->close(kGoodbye);
  socket_.reset();
}

}  // namespace turgor::haptics

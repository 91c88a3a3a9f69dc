#include "turgor/haptics/drivers/web_socket.hpp"

#include <chrono>
#include <utility>

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <fmt/format.h>

#include "turgor/core/assert.hpp"

namespace turgor::haptics {

namespace asio = boost::asio;
namespace beast = boost::beast;
using boost::system::error_code;

namespace {

constexpr std::size_t kLargestMessage = 1 << 20;  // [bytes]

/// Result of a pending operation. It is shared with its handler, which may outlive its caller.
struct Outcome {
  bool done = false;
  error_code error;
};

auto completion_handler(const std::shared_ptr<Outcome>& outcome) {
  outcome->done = false;
  return [outcome](error_code error, auto&&...) {
    outcome->done = true;
    outcome->error = error;
  };
}

}  // namespace

struct WebSocket::Connection {
  std::string address;
  asio::io_context io{1};
  beast::websocket::stream<asio::ip::tcp::socket> stream{io};
  std::shared_ptr<Outcome> read = std::make_shared<Outcome>();
  bool is_reading = false;
  beast::flat_buffer buffer;
  std::string sent;  // must live as long as it is being sent

  ~Connection() {
    error_code ignored;
    stream.next_layer().close(ignored);
    io.restart();
    io.poll();  // runs handlers that were pending
  }

  /// Runs until the operation is done, or the limit is reached.
  bool wait_for(const Outcome& outcome, double limit) {
    TURGOR_CHECK(limit >= 0, "a time limit is not negative");
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::duration<double>(limit);
    io.restart();
    while (!outcome.done)
      if (io.run_one_until(std::chrono::time_point_cast<std::chrono::steady_clock::duration>(deadline)) == 0)
        break;
    return outcome.done;
  }

  Error lost(const std::string& what) const { return {fmt::format("{}: {}", address, what)}; }

  Status finish(const std::shared_ptr<Outcome>& outcome, double limit, const char* what) {
    if (!wait_for(*outcome, limit)) return lost(fmt::format("{} took longer than {:g} s", what, limit));
    if (outcome->error) return lost(outcome->error.message());
    return Done{};
  }

  Status connect(const std::string& host, const std::string& port, double limit) {
    error_code error;
    // TCP connection
    asio::ip::tcp::resolver resolver(io);
    const auto endpoints = resolver.resolve(host, port, error);
    if (error) return lost(error.message());
    auto outcome = std::make_shared<Outcome>();
    asio::async_connect(stream.next_layer(), endpoints, completion_handler(outcome));
    if (Status connected = finish(outcome, limit, "connecting"); !connected) return connected;
    stream.next_layer().set_option(asio::ip::tcp::no_delay(true), error);
    stream.read_message_max(kLargestMessage);
    stream.text(true);
    // WebSocket handshake
    outcome = std::make_shared<Outcome>();
    stream.async_handshake(host + ":" + port, "/", completion_handler(outcome));
    return finish(outcome, limit, "the WebSocket handshake");
  }
};

WebSocket::WebSocket(std::unique_ptr<Connection> connection) : connection_(std::move(connection)) {}
WebSocket::~WebSocket() = default;

Result<std::unique_ptr<WebSocket>> WebSocket::connect(const std::string& address, double limit) {
  const std::size_t colon = address.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == address.size())
    return Error{fmt::format("expected an address HOST:PORT, found \"{}\"", address)};
  auto connection = std::make_unique<Connection>();
  connection->address = address;
  Status connected = connection->connect(address.substr(0, colon), address.substr(colon + 1), limit);
  if (!connected) return connected.error();
  return std::unique_ptr<WebSocket>(new WebSocket(std::move(connection)));
}

Status WebSocket::send(const std::string& message, double limit) {
  TURGOR_ASSERT(connection_ != nullptr, "a message needs a connection");
  Connection& c = *connection_;
  c.sent = message;
  auto outcome = std::make_shared<Outcome>();
  c.stream.async_write(asio::buffer(c.sent), completion_handler(outcome));
  return c.finish(outcome, limit, "sending");
}

Result<std::optional<std::string>> WebSocket::receive(double limit) {
  TURGOR_ASSERT(connection_ != nullptr, "a message needs a connection");
  Connection& c = *connection_;
  if (!c.is_reading) c.stream.async_read(c.buffer, completion_handler(c.read));
  c.is_reading = true;
  if (!c.wait_for(*c.read, limit)) return std::optional<std::string>();
  c.is_reading = false;
  if (c.read->error) return c.lost(c.read->error.message());
  std::optional<std::string> message = beast::buffers_to_string(c.buffer.data());
  c.buffer.consume(c.buffer.size());
  return message;
}

void WebSocket::close(double limit) noexcept {
  try {
    auto outcome = std::make_shared<Outcome>();
    connection_->stream.async_close(beast::websocket::close_code::normal, completion_handler(outcome));
    connection_->wait_for(*outcome, limit);
  } catch (...) {  // no memory: the destructor closes
  }
}

}  // namespace turgor::haptics

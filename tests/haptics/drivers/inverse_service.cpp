#include "tests/haptics/drivers/inverse_service.hpp"

#include <chrono>
#include <mutex>
#include <thread>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <sys/socket.h>

namespace turgor::test {

namespace asio = boost::asio;
namespace beast = boost::beast;
using boost::system::error_code;
using Json = nlohmann::json;

struct InverseService::Server {
  asio::io_context io;
  asio::ip::tcp::acceptor acceptor{io, {asio::ip::address_v4::loopback(), 0}};
  const int port = acceptor.local_endpoint().port();
  std::string force_key;
  std::atomic<bool> stops = false;
  std::atomic<int> open_socket = -1, connections = 0, unanswered = 0;
  std::thread thread;

  mutable std::mutex mutex;  // guards all members below
  Behavior behavior = Behavior::kGood;
  std::vector<std::string> ids{"049D"};
  bool is_calibrated = true;
  Vec3d position, velocity, force;
  std::string grip_kind;
  Json grip;
  std::vector<Json> received;

  Json arm(const std::string& id, bool whole) const {
    const auto vector = [](Vec3d v) { return Json{{"x", v.x}, {"y", v.y}, {"z", v.z}}; };
    Json state_json{{"device_id", id}, {"state", {{"cursor_position", vector(position)}}}};
    if (behavior == Behavior::kOmitting) return state_json;
    state_json["state"]["cursor_velocity"] = vector(velocity);
    state_json["state"]["control_mode"] = "idle";
    state_json["state"]["transform"] = Json::object();
    state_json["status"] = {{"calibrated", is_calibrated}, {"ready", true}};
    if (whole)
      state_json["config"] = {{"type", id == "MINI" ? "minverse" : "inverse3"}, {"preset", "defaults"}};
    if (behavior == Behavior::kHuge) state_json["state"]["cursor_position"]["x"] = 1000;
    if (behavior == Behavior::kOtherTypes) state_json["state"]["cursor_position"] = {0.1, 0.2, 0.3};
    return state_json;
  }
  std::string message(bool whole) const {
    if (behavior == Behavior::kGarbage) return "{\"inverse3\": [ garbage";
    if (behavior == Behavior::kBrokenText) return "{\"inverse3\": [ \xff";
    if (behavior == Behavior::kNoNumber)
      return R"({"inverse3":[{"device_id":"049D","state":{"cursor_position":{"x":NaN,"y":0,"z":0}}}]})";
    Json json{{"inverse3", Json::array()}};
    if (whole) json["session_id"] = 7;
    for (const std::string& id : ids) json["inverse3"].push_back(arm(id, whole));
    if (!grip.is_null()) json[grip_kind] = {{{"device_id", "61548"}, {"state", grip}}};
    return json.dump();
  }
  /// Executes known commands and ignores the rest.
  void execute(const std::string& text) {
    const Json command = Json::parse(text);
    received.push_back(command);
    const Json::json_pointer path("/inverse3/0/commands/set_cursor_force/" + force_key);
    force = {};  // commands hold for one tick
    if (!command.contains(path)) return;
    const Json& f = command[path];
    force = {f["x"].get<double>(), f["y"].get<double>(), f["z"].get<double>()};
  }
  Behavior current_behavior() const {
    const std::lock_guard lock(mutex);
    return behavior;
  }

  void serve(asio::ip::tcp::socket socket) {
    open_socket = socket.native_handle();
    beast::websocket::stream<asio::ip::tcp::socket&> stream(socket);
    error_code error;
    stream.accept(error);
    connections++;
    const auto send = [&](bool whole) {
      std::string text;
      {
        const std::lock_guard lock(mutex);
        text = message(whole);
      }
      stream.write(asio::buffer(text), error);
    };
    send(true);
    while (!error && !stops) {
      beast::flat_buffer buffer;
      stream.read(buffer, error);
      if (error) break;
      {
        const std::lock_guard lock(mutex);
        execute(beast::buffers_to_string(buffer.data()));
      }
      if (socket.available(error) > 0) unanswered++;
      if (current_behavior() == Behavior::kLate) std::this_thread::sleep_for(std::chrono::milliseconds(60));
      while (current_behavior() == Behavior::kSilent && !stops)
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      if (current_behavior() == Behavior::kHangsUp) break;
      send(false);
    }
    open_socket = -1;
  }
  void run() {
    while (!stops) {
      error_code error;
      asio::ip::tcp::socket socket(io);
      acceptor.accept(socket, error);
      if (!error && !stops) serve(std::move(socket));
    }
  }
};

InverseService::InverseService(std::string force_key) : server_(std::make_unique<Server>()) {
  server_->force_key = std::move(force_key);
  server_->thread = std::thread([server = server_.get()] { server->run(); });
}

InverseService::~InverseService() {
  server_->stops = true;
  ::shutdown(server_->acceptor.native_handle(), SHUT_RDWR);
  if (const int socket = server_->open_socket; socket >= 0) ::shutdown(socket, SHUT_RDWR);
  server_->thread.join();
}

std::string InverseService::address() const { return "127.0.0.1:" + std::to_string(server_->port); }

void InverseService::set_behavior(Behavior behavior) {
  const std::lock_guard lock(server_->mutex);
  server_->behavior = behavior;
}
void InverseService::set_arms(std::vector<std::string> ids) {
  const std::lock_guard lock(server_->mutex);
  server_->ids = std::move(ids);
}
void InverseService::set_calibrated(bool is_calibrated) {
  const std::lock_guard lock(server_->mutex);
  server_->is_calibrated = is_calibrated;
}
void InverseService::set_hand(Vec3d position, Vec3d velocity) {
  const std::lock_guard lock(server_->mutex);
  server_->position = position;
  server_->velocity = velocity;
}
void InverseService::set_grip(const std::string& kind, const Json& state) {
  const std::lock_guard lock(server_->mutex);
  server_->grip_kind = kind;
  server_->grip = state;
}
Vec3d InverseService::force() const {
  const std::lock_guard lock(server_->mutex);
  return server_->force;
}
std::vector<Json> InverseService::received() const {
  const std::lock_guard lock(server_->mutex);
  return server_->received;
}
int InverseService::unanswered() const { return server_->unanswered; }
int InverseService::connections() const { return server_->connections; }

}  // namespace turgor::test

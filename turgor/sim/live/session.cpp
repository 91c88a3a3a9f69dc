#include "turgor/sim/live/session.hpp"

#include <utility>

#include "turgor/core/start_thread.hpp"
#include "turgor/sim/live/session_thread.hpp"

namespace turgor {

Session::Session(const std::filesystem::path& file, std::vector<std::string> overrides,
                 const SessionParams& params)
    : params_(params) {
  const auto run = [this, opened = OpenRequest{file, std::move(overrides)}] {
    SessionThread thread{.params = params_,
                         .queue = queue_,
                         .published = now_,
                         .exec = Exec(params_.threads),
                         .source = {opened, nullptr}};
    run_session(thread);
  };
  Result<std::thread> started = start_thread("the session", run);
  if (started) {
    thread_ = std::move(*started);
    return;
  }
  SessionStatus refused;
  refused.error = started.error().message;
  now_.write(std::move(refused));
}

Session::~Session() {
  queue_.end();
  if (thread_.joinable()) thread_.join();
}

void Session::request(Request request) { queue_.push(std::move(request)); }

}  // namespace turgor

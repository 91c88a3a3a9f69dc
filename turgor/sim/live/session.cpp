#include "turgor/sim/live/session.hpp"

#include <utility>

#include "turgor/sim/live/session_thread.hpp"

namespace turgor {

Session::Session(const std::filesystem::path& file, std::vector<std::string> overrides,
                 const SessionParams& params)
    : params_(params) {
  thread_ = std::thread([this, opened = OpenRequest{file, std::move(overrides)}] {
    SessionThread thread{.params = params_,
                         .queue = queue_,
                         .published = now_,
                         .exec = Exec(params_.threads),
                         .source = {opened, nullptr}};
    run_session(thread);
  });
}

Session::~Session() {
  queue_.end();
  thread_.join();
}

void Session::request(Request request) { queue_.push(std::move(request)); }

}  // namespace turgor

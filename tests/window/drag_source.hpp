// Another program's side of drag and drop (XDND 5): drags a file to the window and drops it there.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <xcb/xcb.h>

namespace turgor::test {

class DragSource {
 public:
  DragSource() : connection_(xcb_connect(nullptr, nullptr), xcb_disconnect) {
    const xcb_screen_t* screen = xcb_setup_roots_iterator(xcb_get_setup(connection_.get())).data;
    root_ = screen->root, window_ = xcb_generate_id(connection_.get());
    xcb_create_window(connection_.get(), XCB_COPY_FROM_PARENT, window_, root_, 0, 0, 1, 1, 0,
                      XCB_WINDOW_CLASS_INPUT_OUTPUT, screen->root_visual, 0, nullptr);
    target_ = window_that_accepts_drops();
  }

  bool has_target() const { return target_ != XCB_NONE; }

  /// Drags the file over the target, at a point of the screen.
  void drag(const std::filesystem::path& file, int x, int y) {
    uris_ = "file://" + file.string() + "\r\n";
    xcb_set_selection_owner(connection_.get(), window_, atom("XdndSelection"), XCB_CURRENT_TIME);
    constexpr std::uint32_t kVersion = 5;
    send("XdndEnter", {window_, kVersion << 24, atom("text/uri-list"), 0, 0});
    send("XdndPosition",
         {window_, 0, std::uint32_t(x) << 16 | std::uint32_t(y), XCB_CURRENT_TIME, atom("XdndActionCopy")});
  }

  /// Answers the target. The file is dropped once the target accepts it.
  void answer() {
    while (xcb_generic_event_t* received = xcb_poll_for_event(connection_.get())) {
      const std::unique_ptr<xcb_generic_event_t, void (*)(void*)> event(received, std::free);
      const int kind = event->response_type & ~0x80;
      if (kind == XCB_CLIENT_MESSAGE) take(reinterpret_cast<const xcb_client_message_event_t&>(*event));
      if (kind == XCB_SELECTION_REQUEST) give(reinterpret_cast<const xcb_selection_request_event_t&>(*event));
    }
  }

  bool is_accepted = false, is_finished = false;

 private:
  xcb_atom_t atom(const char* name) {
    const auto cookie = xcb_intern_atom(connection_.get(), 0, std::uint16_t(std::strlen(name)), name);
    xcb_intern_atom_reply_t* reply = xcb_intern_atom_reply(connection_.get(), cookie, nullptr);
    const xcb_atom_t found = reply ? reply->atom : xcb_atom_t(XCB_NONE);
    std::free(reply);
    return found;
  }

  xcb_window_t window_that_accepts_drops() {
    xcb_query_tree_reply_t* tree =
        xcb_query_tree_reply(connection_.get(), xcb_query_tree(connection_.get(), root_), nullptr);
    const xcb_window_t* windows = xcb_query_tree_children(tree);
    xcb_window_t found = XCB_NONE;
    for (int n = 0; n < xcb_query_tree_children_length(tree); n++) {
      const auto cookie =
          xcb_get_property(connection_.get(), 0, windows[n], atom("XdndAware"), XCB_ATOM_ATOM, 0, 1);
      xcb_get_property_reply_t* aware = xcb_get_property_reply(connection_.get(), cookie, nullptr);
      if (aware && xcb_get_property_value_length(aware) > 0) found = windows[n];
      std::free(aware);
    }
    std::free(tree);
    return found;
  }

  void send(const char* type, const std::vector<std::uint32_t>& values) {
    xcb_client_message_event_t message{};
    message.response_type = XCB_CLIENT_MESSAGE, message.format = 32, message.window = target_;
    message.type = atom(type);
    std::memcpy(message.data.data32, values.data(), sizeof message.data.data32);
    xcb_send_event(connection_.get(), 0, target_, 0, reinterpret_cast<const char*>(&message));
    xcb_flush(connection_.get());
  }

  void take(const xcb_client_message_event_t& message) {
    if (message.type == atom("XdndFinished")) is_finished = true;
    if (message.type != atom("XdndStatus") || is_accepted) return;
    is_accepted = message.data.data32[1] & 1;
    if (is_accepted) send("XdndDrop", {window_, 0, XCB_CURRENT_TIME, 0, 0});
  }

  /// Writes the names of the files for the target.
  void give(const xcb_selection_request_event_t& request) {
    xcb_change_property(connection_.get(), XCB_PROP_MODE_REPLACE, request.requestor, request.property,
                        request.target, 8, std::uint32_t(uris_.size()), uris_.data());
    xcb_selection_notify_event_t notice{};
    notice.response_type = XCB_SELECTION_NOTIFY, notice.time = request.time;
    notice.requestor = request.requestor, notice.selection = request.selection;
    notice.target = request.target, notice.property = request.property;
    xcb_send_event(connection_.get(), 0, request.requestor, 0, reinterpret_cast<const char*>(&notice));
    xcb_flush(connection_.get());
  }

  std::unique_ptr<xcb_connection_t, void (*)(xcb_connection_t*)> connection_;
  xcb_window_t root_ = XCB_NONE, window_ = XCB_NONE, target_ = XCB_NONE;
  std::string uris_;
};

}  // namespace turgor::test

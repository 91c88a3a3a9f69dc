#include "turgor/view/drawing_process.hpp"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <memory>
#include <mutex>
#include <new>
#include <optional>
#include <utility>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "turgor/io/files/child.hpp"
#include "turgor/view/drawing_child.hpp"
#include "turgor/view/drawing_message.hpp"

namespace turgor {

namespace {

// Limits of the child. Drivers reserve more addresses than they use, so the limit is on private memory.
constexpr rlim_t kMostMemory = rlim_t(16) << 30, kLargestFile = rlim_t(1) << 30;  // [bytes]

/// An item with the data that its pointers refer to.
struct OwnedItem {
  TriMesh mesh;
  ColorScale scale;
  std::vector<Rgb> colors;
  RenderItem item;
  bool has_scale = false, has_colors = false;
};

/// A picture as the child needs it.
struct DrawingRequest {
  Camera camera;
  int width = 0, height = 0;
  RenderQuality quality = RenderQuality::kFull;
  std::vector<OwnedItem> items;
};

void put_picture(Message& message, const FacePicture& picture) {
  message.put(picture.corner), message.put(picture.right), message.put(picture.up);
  message.put(picture.image.width), message.put(picture.image.height), message.put(picture.image.pixels);
}

bool take_pictures(Message& message, std::vector<FacePicture>& pictures) {
  std::uint64_t count = 0;
  if (!message.take(count) || count > 2) return false;
  for (FacePicture& picture : pictures = std::vector<FacePicture>(std::size_t(count))) {
    Image& image = picture.image;
    if (!message.take(picture.corner) || !message.take(picture.right) || !message.take(picture.up) ||
        !message.take(image.width) || !message.take(image.height) || !message.take(image.pixels))
      return false;
  }
  return true;
}

Message request_of(const std::vector<RenderItem>& items, const Camera& camera, int width, int height,
                   RenderQuality quality) {
  Message message;
  message.put(camera), message.put(width), message.put(height), message.put(quality);
  message.put(std::uint64_t(items.size()));
  for (const RenderItem& item : items) {
    const TriMesh& mesh = *item.mesh;
    message.put(mesh.vertices), message.put(mesh.triangles), message.put(mesh.normals);
    message.put(mesh.scalars);
    message.put(item.color), message.put(item.see_through), message.put(item.opaque);
    message.put(item.is_mark), message.put(item.in_fours), message.put(item.closed);
    message.put(item.wet), message.put(item.cutaway), message.put(item.is_cut_face);
    message.put(std::uint64_t(item.face_pictures.size()));
    for (const FacePicture& picture : item.face_pictures) put_picture(message, picture);
    message.put(item.scale != nullptr);
    if (item.scale) message.put(item.scale->low), message.put(item.scale->high);
    message.put(item.colors != nullptr);
    if (item.colors) message.put(*item.colors);
  }
  return message;
}

bool take_item(Message& message, OwnedItem& owned) {
  TriMesh& mesh = owned.mesh;
  RenderItem& item = owned.item;
  bool good = message.take(mesh.vertices) && message.take(mesh.triangles) && message.take(mesh.normals) &&
              message.take(mesh.scalars) && message.take(item.color) && message.take(item.see_through) &&
              message.take(item.opaque) && message.take(item.is_mark) && message.take(item.in_fours) &&
              message.take(item.closed) && message.take(item.wet) && message.take(item.cutaway) &&
              message.take(item.is_cut_face) && take_pictures(message, item.face_pictures) &&
              message.take(owned.has_scale);
  if (good && owned.has_scale) good = message.take(owned.scale.low) && message.take(owned.scale.high);
  good = good && message.take(owned.has_colors);
  return good && (!owned.has_colors || message.take(owned.colors));
}

std::optional<DrawingRequest> take_request(Message& message) {
  DrawingRequest request;
  std::uint64_t count = 0;
  if (!message.take(request.camera) || !message.take(request.width) || !message.take(request.height) ||
      !message.take(request.quality) || !message.take(count))
    return std::nullopt;
  for (std::uint64_t i = 0; i < count; i++)
    if (!take_item(message, request.items.emplace_back())) return std::nullopt;
  return request;
}

Result<Image> draw(const DrawingRequest& request) {
  std::vector<RenderItem> items;
  for (const OwnedItem& owned : request.items) {
    items.push_back(owned.item);
    items.back().mesh = &owned.mesh;
    if (owned.has_scale) items.back().scale = &owned.scale;
    if (owned.has_colors) items.back().colors = &owned.colors;
  }
  return draw_in_process(items, request.camera, request.width, request.height, request.quality);
}

/// Waits until the socket can be read or written, at most until `end`.
bool wait_for_socket(int socket, short event, std::chrono::steady_clock::time_point end) {
  const auto left = std::chrono::ceil<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
  pollfd waited{socket, event, 0};
  const int ready = poll(&waited, 1, int(std::clamp<std::int64_t>(left.count(), 0, 1 << 30)));
  return ready > 0 || (ready < 0 && errno == EINTR);
}

enum class Sent { kDone, kEnded, kTooLong };

/// Moves all bytes through the socket; `move` sends or receives some.
template <class Move>
Sent move_all(int socket, short event, std::size_t size, double seconds, const Move& move) {
  using Clock = std::chrono::steady_clock;
  const auto patience = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  Clock::time_point end = Clock::now() + patience;
  for (std::size_t at = 0; at < size;) {
    if (!wait_for_socket(socket, event, end)) return Sent::kTooLong;
    const ssize_t moved = move(at);
    if (moved == 0 || (moved < 0 && errno != EINTR && errno != EAGAIN)) return Sent::kEnded;
    if (moved > 0) at += std::size_t(moved), end = Clock::now() + patience;
  }
  return Sent::kDone;
}

Sent send_bytes(int socket, const char* bytes, std::size_t size, double seconds) {
  return move_all(socket, POLLOUT, size, seconds, [&](std::size_t at) {
    return send(socket, bytes + at, size - at, MSG_NOSIGNAL | MSG_DONTWAIT);
  });
}

Sent receive_bytes(int socket, char* bytes, std::size_t size, double seconds) {
  return move_all(socket, POLLIN, size, seconds,
                  [&](std::size_t at) { return recv(socket, bytes + at, size - at, MSG_DONTWAIT); });
}

/// Sends the number of bytes, then the bytes.
Sent send_message(int socket, const Message& message, double seconds) {
  const std::uint64_t size = message.bytes().size();
  const Sent sent = send_bytes(socket, reinterpret_cast<const char*>(&size), sizeof size, seconds);
  return sent == Sent::kDone ? send_bytes(socket, message.bytes().data(), size, seconds) : sent;
}

/// A message of more than `most` bytes comes from a damaged process.
Sent receive_message(int socket, Message& message, double seconds, std::uint64_t most) {
  std::uint64_t size = 0;
  Sent received = receive_bytes(socket, reinterpret_cast<char*>(&size), sizeof size, seconds);
  if (received != Sent::kDone) return received;
  if (size > most) return Sent::kEnded;
  std::string bytes(std::size_t(size), '\0');
  received = receive_bytes(socket, bytes.data(), bytes.size(), seconds);
  if (received == Sent::kDone) message = Message(std::move(bytes));
  return received;
}

/// The program's child; one caller at a time.
struct Drawing {
  std::mutex mutex;
  DrawingProgram program;
  std::unique_ptr<DrawingChild> child;
};
Drawing& the_drawing() {
  static Drawing drawing;
  return drawing;
}

/// Starts the process that draws if there is none. A fork of the process that started it may not use its
/// socket.
Status start_child(Drawing& drawing) {
  if (drawing.child && drawing.child->is_of_this_process()) return Done{};
  drawing.child.reset();
  if (!drawing.program.refusal.empty()) return Error{"cannot draw: " + drawing.program.refusal};
  Result<std::unique_ptr<DrawingChild>> child = DrawingChild::start(drawing.program.arguments);
  if (!child) return child.error();
  drawing.child = std::move(*child);
  return Done{};
}

/// Sends a request and receives its answer of at most `most` bytes.
Sent exchange(const DrawingChild& child, const Message& request, Message& answer, double patience,
              std::uint64_t most) {
  const Sent sent = send_message(child.socket(), request, patience);
  return sent == Sent::kDone ? receive_message(child.socket(), answer, patience, most) : sent;
}

/// Ends the child and describes the failure.
Error failed_drawing(Drawing& drawing, Sent sent) {
  const std::string end = drawing.child->stop();
  drawing.child.reset();
  if (sent == Sent::kTooLong)
    return {
        fmt::format("cannot draw: the process that draws gave no picture for {:g} s and was stopped; are "
                    "memory or processes limited (ulimit -v, ulimit -u)?",
                    drawing.program.patience)};
  return {
      fmt::format("cannot draw: the process that draws {}; are memory or processes limited (ulimit -v, "
                  "ulimit -u)?",
                  end)};
}

Result<Image> draw_asked(Message& asked) {
  try {
    const std::optional<DrawingRequest> request = take_request(asked);
    return request ? draw(*request) : Error{"cannot draw: a damaged request"};
  } catch (const std::bad_alloc&) {
    return Error{"cannot draw: not enough memory"};
  }
}

/// The answer: the pixels, or the error's text.
Message answer_to(Message& asked) {
  const Result<Image> image = draw_asked(asked);
  Message answer;
  answer.put(bool(image));
  if (image)
    answer.put(image->pixels);
  else
    answer.put(std::vector<char>(image.error().message.begin(), image.error().message.end()));
  return answer;
}

}  // namespace

void set_drawing_program(DrawingProgram program) {
  Drawing& drawing = the_drawing();
  const std::lock_guard lock(drawing.mutex);
  drawing.child.reset();
  drawing.program = std::move(program);
}

bool has_drawing_program() {
  Drawing& drawing = the_drawing();
  const std::lock_guard lock(drawing.mutex);
  return !drawing.program.arguments.empty() || !drawing.program.refusal.empty();
}

Result<Image> draw_in_child(const std::vector<RenderItem>& items, const Camera& camera, int width, int height,
                            RenderQuality quality) {
  Drawing& drawing = the_drawing();
  const std::lock_guard lock(drawing.mutex);
  const Message request = request_of(items, camera, width, height, quality);
  constexpr std::uint64_t kLongestText = 1 << 16;
  const std::uint64_t most =
      kLongestText + sizeof(Image::pixels[0]) * std::uint64_t(width) * std::uint64_t(height);

  // ask and wait; a child of another thread may have ended with it, and is replaced once
  Message answer;
  for (;;) {
    if (const Status started = start_child(drawing); !started) return started.error();
    const bool is_own = drawing.child->is_of_this_thread();
    const Sent sent = exchange(*drawing.child, request, answer, drawing.program.patience, most);
    if (sent == Sent::kDone) break;
    if (is_own || sent == Sent::kTooLong) return failed_drawing(drawing, sent);
    drawing.child.reset();
  }

  // read the answer
  bool drawn = false;
  std::vector<char> text;
  Image image{width, height, {}};
  if (answer.take(drawn) && drawn && answer.take(image.pixels) &&
      image.pixels.size() == std::size_t(width) * std::size_t(height))
    return image;
  if (!drawn && answer.take(text)) return Error{std::string(text.begin(), text.end())};
  return failed_drawing(drawing, Sent::kEnded);
}

std::future<void> warm_up_drawing() {
  // the child ends with the thread that started it, so this one starts it
  {
    Drawing& drawing = the_drawing();
    const std::lock_guard lock(drawing.mutex);
    if (drawing.program.arguments.empty() || !start_child(drawing)) return {};
  }
  return std::async(std::launch::async, [] {
    TriMesh triangle{.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}}, .triangles = {{0, 1, 2}}};
    triangle.normals.assign(3, {0, -1, 0});
    const Camera camera = frame_box({{0, 0, 0}, {1, 1, 1}}, {0, -1, 0}, {0, 0, 1}, 1);
    constexpr int kSide = 16;                                        // pixels
    (void)draw_meshes({{.mesh = &triangle}}, camera, kSide, kSide);  // the next picture has the same error
  });
}

int serve_drawings() {
  // end with the parent, and with less than its rights
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  io::lower_limit(RLIMIT_CORE, 0);
  io::lower_limit(RLIMIT_DATA, kMostMemory);
  io::lower_limit(RLIMIT_FSIZE, kLargestFile);

  // draw until the socket closes
  constexpr double kAnyTime = 1e9;  // [s]
  Message asked;
  while (receive_message(STDIN_FILENO, asked, kAnyTime, ~std::uint64_t{0}) == Sent::kDone)
    if (send_message(STDIN_FILENO, answer_to(asked), kAnyTime) != Sent::kDone) return 1;
  return 0;
}

}  // namespace turgor

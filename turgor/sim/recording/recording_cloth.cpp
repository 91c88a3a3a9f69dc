#include "turgor/sim/recording/recording_cloth.hpp"

#include <cmath>

#include <fmt/format.h>

namespace turgor {

namespace {

std::string group_of(const std::string& snapshot, const ClothBody& body) {
  return fmt::format("{}/bodies/{}/", snapshot, body.name);
}

}  // namespace

Status write_state(const SnapshotOut& out, const ClothBody& body, BodyId) {
  std::vector<float> places;
  for (const int v : body.model.place) {
    const Vec3 x = body.state.x[std::size_t(v)];
    places.insert(places.end(), {x.x, x.y, x.z});
  }
  return Writing(out.file, group_of(out.group, body)).array("places", places, 3).status();
}

Status read_state(const SnapshotIn& in, ClothBody& body, BodyId id) {
  const std::string group = group_of(in.group, body);
  Reading reading(in.file, group);
  const auto places = reading.array<float>("places", 3 * body.model.place.size());
  if (!reading.status()) return reading.status();
  for (std::size_t v = 0; v < body.model.place.size(); v++) {
    const Vec3 x{places[3 * v], places[3 * v + 1], places[3 * v + 2]};
    if (!std::isfinite(dot(x, x))) return Error{fmt::format("{}: a place is not a number", group)};
    body.state.x.set(std::size_t(body.model.place[v]), x);
  }
  show(in.exec, body, shown_body(in.shown, id));
  return Done{};
}

}  // namespace turgor

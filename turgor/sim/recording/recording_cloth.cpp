#include "turgor/sim/recording/recording_cloth.hpp"

#include <cmath>

#include <fmt/format.h>

#include "turgor/sim/recording/recording_arrays.hpp"

namespace turgor {

Status write_cloth(Hdf5File& file, const std::string& group, const ClothBody& body) {
  std::vector<float> places;
  for (const int v : body.model.place) {
    const Vec3 x = body.state.x[std::size_t(v)];
    places.insert(places.end(), {x.x, x.y, x.z});
  }
  return Writing(file, group).array("places", places, 3).status();
}

Status read_cloth(const Hdf5File& file, const std::string& group, ClothBody& body) {
  Reading reading(file, group);
  const auto places = reading.array<float>("places", 3 * body.model.place.size());
  if (!reading.status()) return reading.status();
  for (std::size_t v = 0; v < body.model.place.size(); v++) {
    const Vec3 x{places[3 * v], places[3 * v + 1], places[3 * v + 2]};
    if (!std::isfinite(dot(x, x))) return Error{fmt::format("{}: a place is not a number", group)};
    body.state.x.set(std::size_t(body.model.place[v]), x);
  }
  return Done{};
}

}  // namespace turgor

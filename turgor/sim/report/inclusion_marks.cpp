#include "turgor/sim/report/inclusion_marks.hpp"

namespace turgor {

namespace {

bool is_over(const ForceSample& tick, const InnerRegion& inclusion) {
  const double force = norm(tick.force);
  if (!(force > 0)) return false;
  const Vec3d along = tick.force / force, below = inclusion.center - tick.position;
  return dot(below, along) < 0 && norm(below - along * dot(below, along)) < inclusion.radius;
}

Json stretch(const InnerRegion& inclusion, const ForceSample& first, const ForceSample& last) {
  return {{"inclusion", inclusion.name},
          {"from_s", first.time},
          {"to_s", last.time},
          {"from_mm", first.path * 1e3},
          {"to_mm", last.path * 1e3}};
}

}  // namespace

Json over_inclusions(const TouchLog& ticks, const std::vector<InnerRegion>& inclusions) {
  Json found = Json::array();
  for (const InnerRegion& inclusion : inclusions) {
    // merge consecutive ticks over the inclusion into one interval
    const ForceSample *first = nullptr, *last = nullptr;
    for (const ForceSample& tick : ticks) {
      if (is_over(tick, inclusion)) {
        if (!first) first = &tick;
        last = &tick;
      } else if (first) {
        found.push_back(stretch(inclusion, *first, *last));
        first = nullptr;
      }
    }
    // interval that is open at the end of the run
    if (first) found.push_back(stretch(inclusion, *first, *last));
  }
  return found;
}

}  // namespace turgor

#include "turgor/sim/report/inclusion_marks.hpp"

namespace turgor {

namespace {

bool is_over(const ForceSample& tick, const InnerPart& part) {
  const double force = norm(tick.force);
  if (!(force > 0)) return false;
  const Vec3d along = tick.force / force, below = part.center - tick.position;
  return dot(below, along) < 0 && norm(below - along * dot(below, along)) < part.radius;
}

Json stretch(const InnerPart& part, const ForceSample& first, const ForceSample& last) {
  return {{"part", part.name},
          {"from_s", first.time},
          {"to_s", last.time},
          {"from_mm", first.path * 1e3},
          {"to_mm", last.path * 1e3}};
}

}  // namespace

Json over_parts(const TouchLog& ticks, const std::vector<InnerPart>& parts) {
  Json found = Json::array();
  for (const InnerPart& part : parts) {
    const ForceSample *first = nullptr, *last = nullptr;
    for (const ForceSample& tick : ticks) {
      if (is_over(tick, part)) {
        if (!first) first = &tick;
        last = &tick;
      } else if (first) {
        found.push_back(stretch(part, *first, *last));
        first = nullptr;
      }
    }
    if (first) found.push_back(stretch(part, *first, *last));
  }
  return found;
}

}  // namespace turgor

// Cuts and stitches by the caller.
#include "turgor/sim/live/by_hand.hpp"

#include "c/sized.hpp"
#include "c/world.hpp"

namespace turgor::c {

namespace {

tg_cut default_cut() {
  const CutByHand defaults;
  tg_cut cut{};
  cut.size = sizeof cut;
  cut.depth = defaults.depth, cut.duration = defaults.duration;
  return cut;
}
tg_stitch default_stitch() {
  tg_stitch stitch{};
  stitch.size = sizeof stitch;
  stitch.duration = StitchByHand().duration;
  return stitch;
}

std::vector<Vec3d> points_of(const double* points, std::size_t count) {
  constexpr std::size_t kMost = 1 << 20;
  expect(count < kMost, "expected a number of points below a million");
  expect(points != nullptr || count == 0, "expected points, found null");
  std::vector<Vec3d> out;
  for (std::size_t n = 0; n < count; n++)
    out.push_back({points[3 * n], points[3 * n + 1], points[3 * n + 2]});
  return out;
}

std::string text_of(const char* text) { return text ? text : ""; }
/// Tension of a pull; 0 = until the lips meet.
std::optional<double> tension_of(double tension) {
  return tension == 0 ? std::nullopt : std::optional<double>(tension);
}

void put_name(tg_world& world, std::string made, const char** name) {
  if (name) *name = world.names.emplace_back(std::move(made)).c_str();
}

}  // namespace
}  // namespace turgor::c

using namespace turgor;
using namespace turgor::c;

tg_status tg_default_cut(tg_cut* cut, size_t size) {
  return guarded([=] { fill_defaults(default_cut(), cut, size); });
}

tg_status tg_default_stitch(tg_stitch* stitch, size_t size) {
  return guarded([=] { fill_defaults(default_stitch(), stitch, size); });
}

tg_status tg_world_cut(tg_world* world, const tg_cut* given, const char** name) {
  return with(world, [=](tg_world& w) {
    const tg_cut cut = taken(given, default_cut());
    put_name(w,
             required(cut_by_hand(w.exec,
                                  {.body = id_of(w, cut.body),
                                   .name = text_of(cut.name),
                                   .points = points_of(cut.points, cut.point_count),
                                   .depth = cut.depth,
                                   .tilt = cut.tilt,
                                   .duration = cut.duration},
                                  w.scene, *w.world)),
             name);
  });
}

tg_status tg_world_stitch(tg_world* world, const tg_stitch* given, const char** name) {
  return with(world, [=](tg_world& w) {
    const tg_stitch stitch = taken(given, default_stitch());
    put_name(w,
             required(stitch_by_hand(w.exec,
                                     {.body = id_of(w, stitch.body),
                                      .wound = text_of(stitch.wound),
                                      .points = points_of(stitch.points, stitch.point_count),
                                      .thread = stitch.thread ? stitch.thread : StitchByHand().thread,
                                      .tension = tension_of(stitch.tension),
                                      .duration = stitch.duration},
                                     w.scene, *w.world)),
             name);
  });
}

tg_status tg_world_tighten(tg_world* world, const char* stitch, double tension, double duration) {
  return with(world, [=](tg_world& w) {
    expect(stitch != nullptr, "expected the name of a stitch, found null");
    required(tighten_by_hand(w.exec, stitch, tension_of(tension), duration, w.scene, *w.world));
  });
}

#include "app/bench_rhombus.hpp"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "app/print.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/geometry/phantom_liver.hpp"
#include "turgor/models/rhombus/rhombus.hpp"

namespace turgor {

namespace {

using rhombus::FootPoint;
using rhombus::Model;
using rhombus::State;
using rhombus::TouchForce;
using rhombus::TouchInput;

constexpr double kMicro = 1e6, kMilli = 1e3, kRadius = 0.005, kTick = 1e-3;

Model liver(double vertices, double bulge) {
  const TriMesh mesh = phantom_liver(std::sqrt(vertices / 3116));
  rhombus::Body body{.vertices = {}, .triangles = mesh.triangles, .stiffness = {}};
  for (const Vec3 x : mesh.vertices) body.vertices.push_back(Vec3d(x));
  return std::move(*rhombus::build(std::move(body), {.bulge = bulge}));
}

/// Path of the tool: 8 mm deep, 2 cm across the right lobe and back; the depth grows to 10 mm at the far end.
std::vector<TouchInput> path_over(const Model& model, int ticks) {
  std::vector<TouchInput> inputs;
  for (int i = 0; i < ticks; i++) {
    const double fraction = std::abs(2.0 * i / ticks - 1);
    const FootPoint foot = rhombus::find_foot_point(model.surface, model.tree,
                                                    {-0.05 + 0.02 * fraction, 0.01 + 0.005 * fraction, 0.2});
    inputs.push_back({.position = foot.at.position + foot.normal * (kRadius - 0.008 - 0.002 * (1 - fraction)),
                      .radius = kRadius});
  }
  return inputs;
}

TouchForce tick(const Model& model, State& state, const TouchInput& input) {
  TouchForce out;
  rhombus::solve_touches(model, state, {&input, 1}, kTick, {&out, 1});
  return out;
}

void measure_force(const Model& model, const std::vector<TouchInput>& inputs, RhombusRow& row) {
  State state = rhombus::make_state(model, 1);
  std::vector<double> seconds;
  Vec3d before = tick(model, state, inputs[0]).force;
  for (std::size_t i = 1; i < inputs.size(); i++) {
    const Timer timer;
    const TouchForce out = tick(model, state, inputs[i]);
    seconds.push_back(timer.seconds());
    const double distance = norm(inputs[i].position - inputs[i - 1].position);
    row.jump = std::max(row.jump, norm(out.force - before) * std::min(1.0, 1e-5 / distance));
    row.strongest = std::max(row.strongest, norm(out.force));
    before = out.force;
  }
  row.force = median(seconds), row.force_99 = percentile(seconds, 0.99);
}

double measure_picture(const Model& model, const std::vector<TouchInput>& inputs, bool slide,
                       RhombusRow& row) {
  const Exec exec(1);
  State state = rhombus::make_state(model, 1);
  std::vector<double> seconds;
  for (std::size_t i = 0; i < inputs.size(); i += inputs.size() / 60) {
    TouchInput input = inputs[slide ? i : 0];
    input.position.z += 1e-8 * double(i % 2);
    tick(model, state, input);
    const Timer timer;
    rhombus::step(exec, model, state);
    if (i > 0) seconds.push_back(timer.seconds());  // the first run computes surface distances
  }
  row.moved = std::max(row.moved, int(state.moved.size()));
  return median(seconds);
}

}  // namespace

std::vector<RhombusRow> bench_rhombus(const Progress& progress) {
  std::vector<RhombusRow> rows;
  const std::vector<double> sizes = {3116, 12500, 50000, 100000};
  for (const double vertices : sizes) {
    const Model model = liver(vertices, 0), bulging = liver(vertices, 1);
    const std::vector<TouchInput> inputs = path_over(model, 4001);
    RhombusRow row{.vertices = int(model.surface.vertices.size()),
                   .triangles = int(model.surface.triangles.size())};
    measure_force(model, inputs, row);
    row.picture = measure_picture(model, inputs, false, row);
    row.sliding = measure_picture(model, inputs, true, row);
    row.bulging = measure_picture(bulging, inputs, false, row);
    rows.push_back(row);
    if (progress) progress(double(rows.size()) / double(sizes.size()));
  }
  return rows;
}

void print(const std::vector<RhombusRow>& rows) {
  print_plain(
      "A ball of 5 mm slides over a liver at a depth of 8 to 10 mm; one thread, medians.\n\n"
      "{:>9}{:>10}{:>8}{:>12}{:>10}{:>13}{:>15}{:>13}{:>18}\n",
      "vertices", "triangles", "moved", "force[us]", "99 %[us]", "picture[ms]", "volume kept[ms]",
      "sliding[ms]", "jump/10 um[mN]");
  for (const RhombusRow& r : rows)
    print_plain("{:>9}{:>10}{:>8}{:>12.2f}{:>10.2f}{:>13.3f}{:>15.3f}{:>13.3f}{:>18.4f}\n", r.vertices,
                r.triangles, r.moved, r.force * kMicro, r.force_99 * kMicro, r.picture * kMilli,
                r.bulging * kMilli, r.sliding * kMilli, r.jump * 1e3);
  print_plain("{:>9}{:>10}{:>8}{:>12}{:>10}{:>13}   the paper: force < 1 ms, picture 52 ms, Core 2, 2 GHz\n",
              3116, 6228, "-", "< 1000", "-", 52);
  print_plain(
      "\nLargest force {:.4f} N. Picture per moved vertex: {:.1f} ns at the smallest size, {:.1f} ns at "
      "the largest.\n",
      rows[0].strongest, 1e9 * rows.front().picture / rows.front().moved,
      1e9 * rows.back().picture / rows.back().moved);
}

std::string to_json_text(const std::vector<RhombusRow>& rows) {
  nlohmann::ordered_json json{{"bench", "rhombus"}, {"rows", nlohmann::ordered_json::array()}};
  for (const RhombusRow& r : rows)
    json["rows"].push_back({{"vertices", r.vertices},
                            {"triangles", r.triangles},
                            {"moved", r.moved},
                            {"force_us", r.force * kMicro},
                            {"force_p99_us", r.force_99 * kMicro},
                            {"picture_ms", r.picture * kMilli},
                            {"picture_volume_kept_ms", r.bulging * kMilli},
                            {"picture_sliding_ms", r.sliding * kMilli},
                            {"force_max_N", r.strongest},
                            {"jump_per_10_um_N", r.jump}});
  return json.dump(2) + "\n";
}

}  // namespace turgor

#include "app/bench_haptics.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/print.hpp"

namespace turgor {

namespace {

using haptics::TimingReport;
using haptics::WallAnswer;
using haptics::WallTrial;

std::vector<double> powers(double low, double high, int count) {
  std::vector<double> values;
  for (int i = 0; i < count; i++) values.push_back(low * std::pow(high / low, double(i) / (count - 1)));
  return values;
}

void measure_map(const Exec& exec, const HapticsBench& bench, ZWidthMap& map) {
  map.verdicts.resize(bench.stiffness.size() * bench.damping.size());
  parallel_for(exec, std::int64_t(map.verdicts.size()), [&](std::int64_t i) {
    WallTrial trial = bench.trial;
    trial.stiffness = bench.stiffness[std::size_t(i) % bench.stiffness.size()];
    trial.damping = bench.damping[std::size_t(i) / bench.stiffness.size()];
    trial.answer = map.answer;
    trial.frame_rate = map.frame_rate;
    trial.controller = map.controller;
    map.verdicts[std::size_t(i)] = haptics::press_wall(trial);
  });
}

/// Largest stiffness up to which all walls of one damping come to rest [N/m]; 0 if no wall does.
double stiffest(const HapticsBench& bench, const ZWidthMap& map, std::size_t row) {
  double stable = 0;
  for (std::size_t k = 0; k < bench.stiffness.size(); k++) {
    if (!map.verdicts[row * bench.stiffness.size() + k].stable) break;
    stable = bench.stiffness[k];
  }
  return stable;
}

nlohmann::ordered_json to_json(const haptics::Spread& s) {
  return {{"p50_us", 1e6 * s.p50},
          {"p99_us", 1e6 * s.p99},
          {"p999_us", 1e6 * s.p999},
          {"max_us", 1e6 * s.largest}};
}

nlohmann::ordered_json to_json(const HapticLoopRow& row) {
  const TimingReport& r = row.report;
  return {{"model", name_of(row.model)},
          {"target_rate_hz", r.target_rate},
          {"rate_hz", r.rate},
          {"ticks", r.ticks},
          {"missed", r.missed},
          {"missed_empty", row.empty.missed},
          {"period", to_json(r.period)},
          {"jitter", to_json(r.jitter)},
          {"jitter_empty", to_json(row.empty.jitter)},
          {"compute", to_json(r.compute)},
          {"latency", to_json(r.latency)}};
}

nlohmann::ordered_json to_json(const HapticsBench& bench, const ZWidthMap& map) {
  nlohmann::ordered_json speeds = nlohmann::ordered_json::array(), stable = speeds;
  for (std::size_t b = 0; b < bench.damping.size(); b++) {
    const auto begin = map.verdicts.begin() + std::ptrdiff_t(b * bench.stiffness.size());
    nlohmann::ordered_json row = nlohmann::ordered_json::array(), rests = row;
    for (auto v = begin; v != begin + std::ptrdiff_t(bench.stiffness.size()); ++v)
      row.push_back(v->speed), rests.push_back(v->stable);
    speeds.push_back(row), stable.push_back(rests);
  }
  return {{"physics", map.name},
          {"frame_rate_hz", map.frame_rate},
          {"controller", map.controller},
          {"stable", stable},
          {"speed_m_s", speeds}};
}

}  // namespace

HapticsBench bench_haptics(const Exec& exec, double seconds, const Progress& progress) {
  HapticsBench bench;
  bench.stiffness = powers(100, 100000, 31);
  bench.damping = {0, 1, 2, 5, 10, 20, 30, 50, 70, 100, 150, 200};
  for (const bool controller : {false, true})
    for (const auto& [name, answer, rate] : {std::tuple{"1 kHz", WallAnswer::kTick, 1000.0},
                                             {"100 Hz, force held", WallAnswer::kHeld, 100.0},
                                             {"30 Hz, force held", WallAnswer::kHeld, 30.0},
                                             {"30 Hz, local contact model", WallAnswer::kLocal, 30.0}})
      bench.maps.push_back({name, answer, rate, controller, {}});
  constexpr LoopModel kModels[] = {LoopModel::kNone, LoopModel::kWall, LoopModel::kRhombus};
  const std::size_t steps = bench.maps.size() + 2 * std::size(kModels);
  std::size_t done = 0;
  const auto step = [&] {
    if (progress) progress(double(++done) / double(steps));
  };
  for (const double rate : {1000.0, 4000.0})
    for (const LoopModel model : kModels) {
      if (seconds > 0) bench.loops.push_back(measure_loop(rate, model, seconds));
      step();
    }
  for (ZWidthMap& map : bench.maps) measure_map(exec, bench, map), step();
  return bench;
}

void print(const HapticsBench& bench) {
  if (!bench.loops.empty())
    print_plain(
        "Haptic loops with a simulated arm, times in microseconds. Jitter: difference of a period from the "
        "target,\nbeside the jitter of an empty loop at the same time.\n\n"
        "{:>9}{:>9}{:>10}{:>8}{:>7} |{:>8}{:>7}{:>8}{:>8} |{:>9}{:>7}{:>8}{:>8} |{:>9}{:>7}{:>8} |{:>9}\n",
        "goal[Hz]", "model", "rate[Hz]", "missed", "empty", "jitter", "99 %", "99.9 %", "max",
        "empty:", "99 %", "99.9 %", "max", "compute", "99 %", "max", "latency");
  for (const HapticLoopRow& row : bench.loops) {
    const TimingReport &r = row.report, &e = row.empty;
    print_plain(
        "{:>9.0f}{:>9}{:>10.1f}{:>8}{:>7} |{:>8.1f}{:>7.0f}{:>8.0f}{:>8.0f} |{:>9.1f}{:>7.0f}{:>8.0f}"
        "{:>8.0f} |{:>9.2f}{:>7.2f}{:>8.1f} |{:>9.0f}\n",
        r.target_rate, name_of(row.model), r.rate, r.missed, e.missed, 1e6 * r.jitter.p50, 1e6 * r.jitter.p99,
        1e6 * r.jitter.p999, 1e6 * r.jitter.largest, 1e6 * e.jitter.p50, 1e6 * e.jitter.p99,
        1e6 * e.jitter.p999, 1e6 * e.jitter.largest, 1e6 * r.compute.p50, 1e6 * r.compute.p99,
        1e6 * r.compute.largest, 1e6 * r.latency.p50);
  }
  if (!bench.loops.empty())
    for (const std::string& note : bench.loops.back().notes) print_plain("  {}\n", note);

  const haptics::VirtualArm& arm = bench.trial.arm;
  print_plain(
      "\nThe stiffest stable wall [N/m] for an arm of {} kg, {} N.s/m, {} N, encoder {:.0f} um, "
      "held by "
      "a hand of {} kg, {} N.s/m, {} N/m;\nfrom {:.0f} to {:.0f} N/m.\n\n{:<28}{:>11} |",
      arm.mass, arm.viscous, arm.coulomb, 1e6 * arm.encoder, bench.trial.hand_mass, bench.trial.hand_damping,
      bench.trial.hand_stiffness, bench.stiffness.front(), bench.stiffness.back(), "physics", "controller");
  for (const double b : bench.damping) print_plain("{:>7}", fmt::format("B={:g}", b));
  print_plain("\n");
  for (const ZWidthMap& map : bench.maps) {
    print_plain("{:<28}{:>11} |", map.name, map.controller ? "yes" : "no");
    for (std::size_t b = 0; b < bench.damping.size(); b++) print_plain("{:>7.0f}", stiffest(bench, map, b));
    print_plain("\n");
  }
  const double hand = arm.viscous + bench.trial.hand_damping;
  print_plain("{:<28}{:>11} |", "passive: Colgate, 1 kHz", "");
  for (const double b : bench.damping)
    print_plain("{:>7.0f}", std::max(0.0, haptics::colgate_stiffness(arm.viscous, b, 1 / arm.rate)));
  print_plain("\n{:<28}{:>11} |", "rest: (b + B) 2/T, 1 kHz", "");
  for (const double b : bench.damping)
    print_plain("{:>7.0f}", haptics::resting_stiffness(hand, b, 1 / arm.rate));
  print_plain("\n");
}

std::string to_json_text(const HapticsBench& bench) {
  const haptics::VirtualArm& arm = bench.trial.arm;
  nlohmann::ordered_json json{{"bench", "haptics"}, {"loops", nlohmann::ordered_json::array()}};
  for (const HapticLoopRow& row : bench.loops) json["loops"].push_back(to_json(row));
  json["arm"] = {{"mass_kg", arm.mass},
                 {"viscous_n_s_per_m", arm.viscous},
                 {"coulomb_n", arm.coulomb},
                 {"encoder_m", arm.encoder},
                 {"hand_mass_kg", bench.trial.hand_mass},
                 {"hand_damping_n_s_per_m", bench.trial.hand_damping},
                 {"hand_stiffness_n_per_m", bench.trial.hand_stiffness}};
  json["stiffness_n_per_m"] = bench.stiffness;
  json["damping_n_s_per_m"] = bench.damping;
  json["z_width"] = nlohmann::ordered_json::array();
  for (const ZWidthMap& map : bench.maps) json["z_width"].push_back(to_json(bench, map));
  return json.dump(2) + "\n";
}

}  // namespace turgor

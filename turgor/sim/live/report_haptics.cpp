// Report of the haptic loop of a run in real time: timing and actions of the safety layer.
#include <algorithm>

#include <fmt/format.h>

#include "turgor/sim/live/live_run.hpp"
#include "turgor/sim/report/section.hpp"

namespace turgor {

namespace {

using namespace units;
constexpr Unit kRate{"per_s", "Hz"}, kMillijoules{"mJ", "mJ", 1e3};
/// units of keys that contain their unit: "period_us.p99"
constexpr Unit kOfMicroseconds{"", "µs", 1e6}, kOfMilliseconds{"", "ms", 1e3};

struct HapticsInput {
  std::string device, tool;
  haptics::TimingReport timing;
  FrameTiming frames;
};
using H = HapticsInput;

double missed_fraction(const haptics::TimingReport& timing) {
  return double(timing.missed) / double(std::max<std::uint64_t>(1, timing.missed + timing.ticks));
}

/// Number of corrections of the device's force. Waiting and ramping are not counted, because every start has
/// them.
std::uint64_t actions(const haptics::SafetyCounts& safety) {
  return safety.not_finite + safety.silent + safety.damped + safety.slewed + safety.saturated + safety.lost;
}

const Quantity<H> kHaptics[] = {
    {"name", kNone, "", [](const H&) -> Json { return "the haptic loop"; }, kInReport},
    {"device", kNone, "device", [](const H& h) -> Json { return h.device; }, kEverywhere},
    {"tool", kNone, "tool of the device", [](const H& h) -> Json { return h.tool; }, kEverywhere},
    {"ticks", kCount, "ticks", [](const H& h) -> Json { return h.timing.ticks; }, kInTable},
    {"seconds", {"", "s"}, "wall time", [](const H& h) -> Json { return h.timing.seconds; }, kInTable},
    {"rate_target", kRate, "", [](const H& h) -> Json { return h.timing.target_rate; }, kInReport},
    {"rate", kRate, "ticks per second", [](const H& h) -> Json { return h.timing.rate; }, kEverywhere,
     "haptic ticks per second"},
    {"missed", kNone, "fraction of ticks missed",
     [](const H& h) -> Json { return missed_fraction(h.timing); }, kEverywhere},
    {"missed_ticks", kCount, "ticks missed", [](const H& h) -> Json { return h.timing.missed; }, kInTable},
    {"period_us.p50", kOfMicroseconds, "tick period, median",
     [](const H& h) -> Json { return h.timing.period.p50; }, kInTable},
    {"period_us.p99", kOfMicroseconds, "tick period, 99th percentile",
     [](const H& h) -> Json { return h.timing.period.p99; }, kEverywhere},
    {"period_us.p999", kOfMicroseconds, "", [](const H& h) -> Json { return h.timing.period.p999; },
     kInReport},
    {"period_us.max", kOfMicroseconds, "tick period, longest",
     [](const H& h) -> Json { return h.timing.period.largest; }, kInTable},
    {"jitter_us.p50", kOfMicroseconds, "", [](const H& h) -> Json { return h.timing.jitter.p50; }, kInReport},
    {"jitter_us.p99", kOfMicroseconds, "jitter, 99th percentile",
     [](const H& h) -> Json { return h.timing.jitter.p99; }, kInTable},
    {"jitter_us.p999", kOfMicroseconds, "", [](const H& h) -> Json { return h.timing.jitter.p999; },
     kInReport},
    {"jitter_us.max", kOfMicroseconds, "jitter, largest",
     [](const H& h) -> Json { return h.timing.jitter.largest; }, kInTable},
    {"compute_us.p50", kOfMicroseconds, "computation per tick, median",
     [](const H& h) -> Json { return h.timing.compute.p50; }, kInTable},
    {"compute_us.p99", kOfMicroseconds, "computation per tick, 99th percentile",
     [](const H& h) -> Json { return h.timing.compute.p99; }, kEverywhere},
    {"compute_us.p999", kOfMicroseconds, "", [](const H& h) -> Json { return h.timing.compute.p999; },
     kInReport},
    {"compute_us.max", kOfMicroseconds, "computation per tick, longest",
     [](const H& h) -> Json { return h.timing.compute.largest; }, kInTable},
    {"latency_us.p50", kOfMicroseconds, "latency from pose to force, median",
     [](const H& h) -> Json { return h.timing.latency.p50; }, kEverywhere},
    {"latency_us.p99", kOfMicroseconds, "latency from pose to force, 99th percentile",
     [](const H& h) -> Json { return h.timing.latency.p99; }, kInTable},
    {"latency_us.p999", kOfMicroseconds, "", [](const H& h) -> Json { return h.timing.latency.p999; },
     kInReport},
    {"latency_us.max", kOfMicroseconds, "latency from pose to force, longest",
     [](const H& h) -> Json { return h.timing.latency.largest; }, kInTable},
    {"model_age_ms.p50", kOfMilliseconds, "age of the model's data, median",
     [](const H& h) -> Json { return h.timing.age.p50; }, kInTable},
    {"model_age_ms.p99", kOfMilliseconds, "… 99th percentile",
     [](const H& h) -> Json { return h.timing.age.p99; }, kInTable},
    {"model_age_ms.p999", kOfMilliseconds, "", [](const H& h) -> Json { return h.timing.age.p999; },
     kInReport},
    {"model_age_ms.max", kOfMilliseconds, "", [](const H& h) -> Json { return h.timing.age.largest; },
     kInReport},
    {"force_jump_max", kNewtons, "largest jump of a force between ticks",
     [](const H& h) -> Json { return h.timing.force_jump; }, kEverywhere},
    {"torque_jump_max", kTorque, "largest jump of a torque",
     [](const H& h) -> Json { return h.timing.torque_jump; }, kInTable},
    {"model_jump_max", kNewtons, "largest jump of the model's force",
     [](const H& h) -> Json { return h.timing.model_force_jump; }, kInTable},
    {"lowest_energy", kMillijoules, "lowest energy",
     [](const H& h) -> Json { return h.timing.lowest_energy; }, kInTable},
    {"safety.actions", kCount, "safety actions, after the soft start",
     [](const H& h) -> Json { return actions(h.timing.safety); }, kInSummary},
    {"safety.not_finite", kCount, "ticks without a finite force",
     [](const H& h) -> Json { return h.timing.safety.not_finite; }, kInTable},
    {"safety.silent", kCount, "ticks without an answer of the model",
     [](const H& h) -> Json { return h.timing.safety.silent; }, kInTable},
    {"safety.waiting", kCount, "", [](const H& h) -> Json { return h.timing.safety.waiting; }, kInReport},
    {"safety.ramping", kCount, "", [](const H& h) -> Json { return h.timing.safety.ramping; }, kInReport},
    {"safety.damped", kCount, "ticks damped", [](const H& h) -> Json { return h.timing.safety.damped; },
     kInTable},
    {"safety.slewed", kCount, "ticks with a limited slope",
     [](const H& h) -> Json { return h.timing.safety.slewed; }, kInTable},
    {"safety.saturated", kCount, "ticks at the force limit",
     [](const H& h) -> Json { return h.timing.safety.saturated; }, kInTable},
    {"safety.lost", kCount, "ticks without the device",
     [](const H& h) -> Json { return h.timing.safety.lost; }, kInTable},
    {"frames", kCount, "frames", [](const H& h) -> Json { return h.frames.frames; }, kInTable},
    {"frames_late", kCount, "late frames", [](const H& h) -> Json { return h.frames.late; }, kInTable},
    {"frame_latest", kMilliseconds, "… largest delay", [](const H& h) -> Json { return h.frames.latest; },
     kInTable},
};

std::vector<std::string> notes_of(LiveRun& live) {
  std::vector<std::string> notes = live.notes;
  for (std::string& note : live.touch->notes()) notes.push_back(std::move(note));
  return notes;
}

}  // namespace

Json haptics_report(LiveRun& live) {
  const HapticsInput input{live.device->spec().name, live.tool, live.touch->timing(), live.touch->frames()};
  Json json = values_of(kHaptics, input);
  json["notes"] = notes_of(live);
  return json;
}

Section haptics_section() {
  return {"The haptic loop", "hand",
          [](const Json& report) {
            return report.contains("haptics") ? Json::array({report.at("haptics")}) : Json::array();
          },
          captions_of(kHaptics)};
}

std::vector<std::string> haptics_warnings(LiveRun& live) {
  const haptics::TimingReport timing = live.touch->timing();
  const FrameTiming frames = live.touch->frames();
  std::vector<std::string> warnings = notes_of(live);
  constexpr double kMissedWarningFraction = 1e-3;
  if (missed_fraction(timing) > kMissedWarningFraction)
    warnings.push_back(fmt::format("the haptic loop missed {} of {} ticks: the machine is overloaded",
                                   timing.missed, timing.missed + timing.ticks));
  if (frames.late > 0)
    warnings.push_back(
        fmt::format("{} of {} frames were late, by up to {:.0f} ms: bodies moved more slowly than the device",
                    frames.late, frames.frames, frames.latest * kMilliseconds.scale));
  return warnings;
}

}  // namespace turgor

#include "turgor/sim/report/report_suture.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "turgor/sim/report/section.hpp"

namespace turgor {

namespace {

using namespace units;

const char* phase_name(lattice::StitchPhase phase) {
  switch (phase) {
    case lattice::StitchPhase::kWaiting:
      return "waiting";
    case lattice::StitchPhase::kPulled:
      return "pulled";
    case lattice::StitchPhase::kKnotted:
      return "knotted";
    case lattice::StitchPhase::kPulledOut:
      return "pulled out";
    case lattice::StitchPhase::kBroken:
      return "broken";
  }
  return "";
}

StitchSample sample_of_stitch(const lattice::Stitch& stitch, const lattice::Motion& motion) {
  StitchSample sample{.along = stitch.along,
                      .tension = stitch.tension,
                      .gape = gape_under(stitch, motion),
                      .phase = stitch.phase,
                      .ended = stitch.ended};
  if (bears(stitch.phase) && stitch.length > 0) sample.stretch = loop_length(stitch, motion) - stitch.length;
  for (const Vec3d f : stitch_forces(stitch, motion)) sample.force = std::max(sample.force, norm(f));
  return sample;
}

const SutureSample& last_of(const SutureMeasures& suture) {
  static const SutureSample kNone;
  return suture.series.empty() ? kNone : suture.series.back();
}

using U = SutureMeasures;
const Quantity<U> kSuture[] = {
    {"name", kNone, "", [](const U& u) -> Json { return u.name; }, kInReport},
    {"wound", kNone, "closes", [](const U& u) -> Json { return u.wound; }},
    {"thread", kNone, "thread", [](const U& u) -> Json { return u.thread; }},
    {"pattern", kNone, "pattern", [](const U& u) -> Json { return u.pattern; }},
    {"thread_length", kMillimeters, "thread in the stitches",
     [](const U& u) -> Json { return last_of(u).thread_length; }},
    {"stitches_bearing", kCount, "stitches that bear", [](const U& u) -> Json { return last_of(u).bearing; },
     kEverywhere},
    {"pulled_out", kCount, "stitches pulled out", [](const U& u) -> Json { return last_of(u).pulled_out; }},
    {"broken", kCount, "threads broken", [](const U& u) -> Json { return last_of(u).broken; }},
    {"gape_max", kMillimeters, "gape under the stitches, largest",
     [](const U& u) -> Json { return last_of(u).gape_max; }, kEverywhere, "gape under {}"},
    {"closing_force", kNewtons, "closing force of the wound",
     [](const U& u) -> Json { return last_of(u).closing_force; }, kEverywhere, "closing force of {}"},
    {"skin_force", kNewtons, "skin tension of the CT over the cut",
     [](const U& u) -> Json { return u.skin_force; }},
    {"tension_max", kNewtons, "largest tension of a thread",
     [](const U& u) -> Json { return last_of(u).tension_max; }, kEverywhere},
};

const Quantity<SutureSample> kSutureSeries[] = {
    {"time", kSeconds, "time", [](const SutureSample& s) -> Json { return s.time; }},
    {"closing_force", kNewtons, "closing force",
     [](const SutureSample& s) -> Json { return s.closing_force; }},
    {"tension_max", kNewtons, "largest tension", [](const SutureSample& s) -> Json { return s.tension_max; }},
    {"gape_max", kMillimeters, "gape under the stitches",
     [](const SutureSample& s) -> Json { return s.gape_max; }},
    {"bearing", kCount, "stitches that bear", [](const SutureSample& s) -> Json { return s.bearing; }},
};

using S = StitchSample;
const Quantity<S> kStitch[] = {
    {"along", kMillimeters, "along the cut", [](const S& s) -> Json { return s.along; }},
    {"state", kNone, "state", [](const S& s) -> Json { return phase_name(s.phase); }},
    {"tension", kNewtons, "tension of the thread", [](const S& s) -> Json { return s.tension; }},
    {"stretch", kMillimeters, "stretch of the thread", [](const S& s) -> Json { return s.stretch; }},
    {"force", kNewtons, "force on the tissue", [](const S& s) -> Json { return s.force; }},
    {"gape", kMillimeters, "gape", [](const S& s) -> Json { return s.gape; }},
    {"ended_at", kSeconds, "ended at",
     [](const S& s) -> Json { return s.ended > 0 ? Json(s.ended) : absent(); }},
};

}  // namespace

SutureMeasures make_suture_measures(const World& world, const Suture& suture) {
  return {.name = suture.scene.name,
          .wound = world.cuts[std::size_t(suture.scene.incision)].blade.name,
          .thread = suture.scene.material,
          .pattern = suture.scene.is_running ? "running" : "interrupted"};
}

void measure_suture(const World& world, const Suture& suture, SutureMeasures& measures) {
  if (!suture.closure) return;
  const LatticeBody& body = world.lattice_bodies[std::size_t(suture.scene.body)];
  const lattice::Motion& motion = body.state->motion;
  SutureSample sample{.time = time_of(world),
                      .closing_force = closing_force(body, suture, world.sutures),
                      .thread_length = thread_length(*suture.closure)};
  measures.stitches.clear();
  for (const lattice::Stitch& stitch : suture.closure->stitches) {
    const StitchSample& one = measures.stitches.emplace_back(sample_of_stitch(stitch, motion));
    sample.pulled_out += one.phase == lattice::StitchPhase::kPulledOut;
    sample.broken += one.phase == lattice::StitchPhase::kBroken;
    if (!bears(one.phase)) continue;
    sample.tension_max = std::max(sample.tension_max, one.tension);
    sample.gape_max = sample.bearing == 0 ? one.gape : std::max(sample.gape_max, one.gape);
    sample.bearing++;
  }
  measures.series.push_back(sample);
}

Json suture_report(const SutureMeasures& suture) {
  Json json = values_of(kSuture, suture);
  add_rows(json, "stitch_columns", "stitches", kStitch, suture.stitches);
  add_rows(json, "series_columns", "series", kSutureSeries, suture.series);
  return json;
}

std::vector<std::string> suture_warnings(const World& world) {
  constexpr double kOpen = 3e-4;  // [m]
  std::vector<std::string> warnings;
  for (const Suture& suture : world.sutures) {
    SutureMeasures measures = make_suture_measures(world, suture);
    measure_suture(world, suture, measures);
    const SutureSample& now = last_of(measures);
    if (now.pulled_out > 0)
      warnings.push_back(
          fmt::format("suture '{}': {} of {} stitches tore out of the tissue: more stitches, or a "
                      "smaller tension, load each point less",
                      suture.scene.name, now.pulled_out, measures.stitches.size()));
    if (now.broken > 0)
      warnings.push_back(
          fmt::format("suture '{}': the thread of {} of {} stitches broke: more stitches, or a "
                      "stronger thread, hold the wound",
                      suture.scene.name, now.broken, measures.stitches.size()));
    if (suture.scene.pull.until_closed && now.bearing > 0 && now.gape_max > kOpen)
      warnings.push_back(
          fmt::format("suture '{}': the wound gapes by {:.2f} mm under a stitch: a larger bite, more "
                      "stitches or a longer run "
                      "close it",
                      suture.scene.name, 1e3 * now.gape_max));
  }
  return warnings;
}

Section suture_section() {
  return {"Sutures", "suture", [](const Json& report) { return items_of(report, "sutures"); },
          captions_of(kSuture)};
}

}  // namespace turgor

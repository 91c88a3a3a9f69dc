#include "turgor/sim/report/report.hpp"

#include <cmath>
#include <ctime>
#include <fstream>
#include <numeric>
#include <thread>

#include <sys/utsname.h>

#include "turgor/core/hash.hpp"
#include "turgor/core/plain_text.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/sim/report/report_cloth.hpp"
#include "turgor/sim/report/report_compare.hpp"
#include "turgor/sim/report/report_lattice.hpp"
#include "turgor/sim/report/report_organs.hpp"
#include "turgor/sim/report/report_rhombus.hpp"
#include "turgor/sim/report/report_sfem.hpp"
#include "turgor/sim/report/report_skin.hpp"
#include "turgor/sim/report/report_texture.hpp"
#include "turgor/sim/report/report_touch.hpp"
#include "turgor/sim/report/section.hpp"
#include "turgor/sim/report/verdict.hpp"

namespace turgor {

namespace {

using namespace units;

std::string processor_name() {
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);)
    if (line.starts_with("model name")) return line.substr(std::min(line.size(), line.find(':') + 2));
  return "unknown";
}

Json machine_report(const Exec& exec) {
  utsname system{};
  uname(&system);
  return {{"processor", processor_name()},
          {"instructions", program_instructions()},
          {"cores", std::thread::hardware_concurrency()},
          {"threads", exec.threads()},
          {"system", std::string(system.sysname) + " " + system.release}};
}

struct Timing {
  const Measures& measures;
  const RunFacts& facts;
};

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }
double mean(const std::vector<double>& values) {
  return values.empty() ? 0 : sum(values) / double(values.size());
}

const Quantity<Timing> kTiming[] = {
    {"load", kSeconds, "reading and building", [](const Timing& t) -> Json { return t.facts.load_seconds; },
     kEverywhere},
    {"simulation", kSeconds, "", [](const Timing& t) -> Json { return t.facts.simulation_seconds; },
     kInReport},
    {"physics", kSeconds, "physics", [](const Timing& t) -> Json { return sum(t.measures.frame_seconds); },
     kEverywhere},
    {"frames", kCount, "", [](const Timing& t) -> Json { return t.measures.frame_seconds.size(); },
     kInReport},
    {"frame_mean", kMilliseconds, "", [](const Timing& t) -> Json { return mean(t.measures.frame_seconds); },
     kInReport},
    {"frame_p50", kMilliseconds, "frame, median",
     [](const Timing& t) -> Json { return percentile(t.measures.frame_seconds, 0.5); }, kInSummary,
     "frame (median)"},
    {"frame_p99", kMilliseconds, "frame, 99th percentile",
     [](const Timing& t) -> Json { return percentile(t.measures.frame_seconds, 0.99); }, kInSummary,
     "frame (99th percentile)"},
    {"frame_max", kMilliseconds, "",
     [](const Timing& t) -> Json { return percentile(t.measures.frame_seconds, 1); }, kInReport},
};
/// Timing that is known after all output.
const Quantity<RunFacts> kOutputTiming[] = {
    {"drawing", kSeconds, "drawing", [](const RunFacts& f) -> Json { return f.drawing_seconds; },
     kEverywhere},
    {"files", kSeconds, "writing files", [](const RunFacts& f) -> Json { return f.file_seconds; },
     kEverywhere},
    {"output", kSeconds, "", [](const RunFacts& f) -> Json { return f.output_seconds; }, kInReport},
    {"resumed_after", kSeconds, "before it was resumed",
     [](const RunFacts& f) -> Json { return f.resumed_after > 0 ? Json(f.resumed_after) : absent(); },
     kEverywhere},
    {"total", kSeconds, "total", [](const RunFacts& f) -> Json { return f.total_seconds; }, kEverywhere},
};

/// Local date, as 2026-11-25.
std::string today() {
  const std::time_t now = std::time(nullptr);
  std::tm local{};
  char text[16] = "";
  if (localtime_r(&now, &local)) std::strftime(text, sizeof text, "%Y-%m-%d", &local);
  return text;
}

Json timing_report(const Measures& measures, const RunFacts& facts) {
  Json json = values_of(kTiming, Timing{measures, facts}), series = Json::array();
  for (const double seconds : measures.frame_seconds)
    series.push_back(rounded(seconds * kMilliseconds.scale));
  json["frame_ms"] = series;
  json["date"] = today();
  return json;
}

struct TissueInput {
  std::string body;
  const TissueRow& row;
};
/// Laws of the bodies, their values, and the source of each value.
const Quantity<TissueInput> kTissue[] = {
    {"name", kNone, "", [](const TissueInput& t) -> Json { return t.body + ": " + t.row.component; },
     kInReport},
    {"law", kNone, "law", [](const TissueInput& t) -> Json { return t.row.law; }},
    {"values", kNone, "values", [](const TissueInput& t) -> Json { return t.row.values; }},
    {"source", kNone, "source", [](const TissueInput& t) -> Json { return t.row.source; }},
};

Json tissue_report(const Scene& scene, const World& world) {
  Json rows = Json::array();
  for_each_kind(scene, world, [&](BodyKind, const auto& scenes, const auto&) {
    for (const auto& body : scenes)
      if constexpr (requires { body.tissues; })
        for (const TissueRow& row : body.tissues)
          rows.push_back(values_of(kTissue, TissueInput{body.name, row}));
  });
  return rows;
}

/// Copy with plain_text in every key and text.
Json plain_json(const Json& json) {
  if (json.is_string()) return plain_text(json.get_ref<const std::string&>());
  if (!json.is_structured()) return json;
  Json plain = json.is_array() ? Json::array() : Json::object();
  for (const auto& [key, value] : json.items())
    if (json.is_array())
      plain.push_back(plain_json(value));
    else
      plain[plain_text(key)] = plain_json(value);
  return plain;
}

Json scene_report(const Scene& scene) {
  return {{"file", scene.file.string()},
          {"overrides", scene.overrides},
          {"duration_s", scene.duration},
          {"frame_rate_per_s", scene.frame_rate}};
}

Json parameter_report(const Scene& scene) {
  Json parameters = Json::array();
  for (const SceneParameter& p : scene.parameters)
    parameters.push_back({{"key", p.key}, {"value", p.value}, {"unit", p.unit}, {"source", p.source}});
  return parameters;
}

}  // namespace

std::string program_version() { return TURGOR_VERSION; }

std::string program_instructions() {
#if defined(__AVX512F__) && defined(__AVX512VL__) && defined(__AVX512BW__) && defined(__AVX512DQ__)
  return "x86-64-v4";
#elif defined(__AVX2__) && defined(__FMA__) && defined(__BMI2__)
  return "x86-64-v3";
#elif defined(__SSE4_2__) && defined(__POPCNT__)
  return "x86-64-v2";
#elif defined(__x86_64__)
  return "x86-64";
#else
  return "another architecture";
#endif
}

Json simulation_report(const Exec& exec, const Scene& scene, const World& world, const Measures& measures,
                       const RunFacts& facts) {
  Json bodies = Json::array(), wounds = Json::array(), sutures = Json::array(), tools = Json::array();
  const ReportInput input{exec, world, measures};
  for_each_kind(scene, world, [&](BodyKind kind, const auto& scenes, const auto& of_kind) {
    for (std::size_t b = 0; b < of_kind.size(); b++) {
      bodies.push_back(report_body(input, scenes[b], of_kind[b], BodyId{kind, int(b)}));
      if constexpr (is_touched<decltype(of_kind[b])>)
        if (Json texture = texture_report(scenes[b].texture, of_kind[b]); !texture.is_null())
          bodies.back()["texture"] = std::move(texture);
    }
  });
  for (const CutMeasures& cut : measures.cuts) wounds.push_back(wound_report(cut));
  for (const SutureMeasures& suture : measures.sutures) sutures.push_back(suture_report(suture));
  for (std::size_t t = 0; t < world.tools.size(); t++)
    tools.push_back(tool_report(scene.tools[t], world.tools[t], world));
  return {{"program", "turgor"},
          {"version", program_version()},
          {"scene", scene_report(scene)},
          {"machine", machine_report(exec)},
          {"bodies", bodies},
          {"wounds", wounds},
          {"sutures", sutures},
          {"skin", skin_report(exec, world)},
          {"tools", tools},
          {"attachments", attachment_report(world)},
          {"body_contacts", body_contact_report(world)},
          {"profiles", profile_report(measures)},
          {"costs", cost_report(world, measures)},
          {"tissues", tissue_report(scene, world)},
          {"solver", solver_report(measures)},
          {"timing", timing_report(measures, facts)},
          {"simulated_s", rounded(time_of(world))},
          {"state_hash", hash_text(state_hash(world))},
          {"parameters", parameter_report(scene)},
          {"scene_text", scene.text}};
}

std::string json_text(const Json& report, int indent) { return plain_json(report).dump(indent); }

Json bodies_of(const Json& report, BodyKind kind) {
  Json bodies = Json::array();
  for (const Json& body : report.value("bodies", Json::array()))
    if (body.value("model", "") == model_name(kind)) bodies.push_back(body);
  return bodies;
}

void add_outputs(Json& report, const RunFacts& facts) {
  Json pictures = Json::array(), deformed = Json::array();
  for (const ReportPicture& p : facts.pictures)
    pictures.push_back({{"file", p.file}, {"caption", p.caption}, {"large", p.large}});
  for (const DeformedCtReport& d : facts.deformed) deformed.push_back(deformed_report(d));
  report["deformed_ct"] = deformed;
  report["pictures"] = pictures;
  report["more_pictures"] = facts.more_pictures;
  report["files"] = facts.files;
  report["warnings"] = facts.warnings;
  report["verdict"] = verdict_of(report);
  report["timing"].update(values_of(kOutputTiming, facts));
}

Section tissue_section() {
  return {"Tissues", "component", [](const Json& report) { return items_of(report, "tissues"); },
          captions_of(kTissue), true};
}

Section timing_section() {
  std::vector<Caption> captions = captions_of(kTiming);
  const std::vector<Caption> more = captions_of(kOutputTiming);
  captions.insert(captions.end(), more.begin(), more.end());
  return {"", "wall time", [](const Json& report) { return Json::array({report.at("timing")}); }, captions};
}

}  // namespace turgor

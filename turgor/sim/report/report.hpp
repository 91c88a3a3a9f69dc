// What a run says about itself: report.json for programs, and report.html, one file with its pictures and
// curves inside, for people. Keys carry their units.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/sim/report/json_numbers.hpp"
#include "turgor/sim/report/measures.hpp"
#include "turgor/sim/scene/scene.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

/// "0.1.0"
std::string program_version();
/// Of the processor, those that this build may use: "x86-64" to "x86-64-v4". With others, other last bits.
std::string program_instructions();

/// A file of the output folder, for the report.
struct ReportPicture {
  std::string file, caption;
  bool large = false;  // over the whole width
};

/// How a CT was resampled.
struct DeformedCtReport {
  std::string body, file;
  Int3 size;
  double seconds = 0;
  double mass_error = 0;  // of Σ (HU + 1000) · volume [1]
  long folds = 0;         // tetrahedra turned inside out
};

/// What a run knows besides scene, world and measures.
struct RunFacts {
  double load_seconds = 0, simulation_seconds = 0, output_seconds = 0, total_seconds = 0;
  double drawing_seconds = 0;  // of the last three: making pictures, and what is resampled for them
  double file_seconds = 0;     // writing files
  std::vector<ReportPicture> pictures;
  std::string more_pictures;       // how to get those that were not drawn; empty = all were
  std::vector<std::string> files;  // others that were written
  std::vector<DeformedCtReport> deformed;
  std::vector<std::string> warnings;
};

/// What the reports of bodies are made from; every model has a report_body(input, scene, body, id).
struct ReportInput {
  const Exec& exec;
  const World& world;
  const Measures& measures;
};

/// The part of the report that the simulation decides.
Json simulation_report(const Exec& exec, const Scene& scene, const World& world, const Measures& measures,
                       const RunFacts& facts);
/// The bodies of one model in a report.
Json bodies_of(const Json& report, BodyKind kind);
/// Adds what was written: pictures, files, the deformed CT, warnings.
void add_outputs(Json& report, const RunFacts& facts);

/// As a file; names of files that are not UTF-8 lose what is not.
std::string json_text(const Json& report, int indent = 1);
/// A page with the pictures of `folder` and curves inside; needs nothing else. `motion` is HTML for the run
/// in three dimensions.
std::string report_html(const Json& report, const std::filesystem::path& folder,
                        const std::string& motion = {});

}  // namespace turgor

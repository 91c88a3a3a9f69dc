// Report of a run: report.json for programs, and report.html, one file with embedded pictures and curves.
// Keys include their units.
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
/// Instruction set that this build may use: "x86-64" to "x86-64-v4". Different ones give different last bits.
std::string program_instructions();

/// A picture in the output folder.
struct ReportPicture {
  std::string file, caption;
  bool large = false;  // over the full width
};

/// Result of resampling a CT.
struct DeformedCtReport {
  std::string body, file;
  Int3 size;
  double seconds = 0;
  double mass_error = 0;  // of Σ (HU + 1000) · volume over the CT, relative to the body [1]
  long folds = 0;         // inverted tetrahedra
};

/// Facts of a run besides scene, world and measures.
struct RunFacts {
  double load_seconds = 0, simulation_seconds = 0, output_seconds = 0, total_seconds = 0;
  double drawing_seconds = 0;  // included in the last three: drawing and resampling of pictures
  double file_seconds = 0;     // writing files
  double resumed_after = 0;    // wall time of a killed run that this one continues [s]
  std::vector<ReportPicture> pictures;
  std::string more_pictures;       // command for pictures that were not drawn; empty = all were drawn
  std::vector<std::string> files;  // other files
  std::vector<DeformedCtReport> deformed;
  std::vector<std::string> warnings;
};

/// Input of body reports; every model has a report_body(input, scene, body, id).
struct ReportInput {
  const Exec& exec;
  const World& world;
  const Measures& measures;
};

/// Deterministic and timing data of the simulation.
Json simulation_report(const Exec& exec, const Scene& scene, const World& world, const Measures& measures,
                       const RunFacts& facts);
/// Bodies of one model in a report.
Json bodies_of(const Json& report, BodyKind kind);
/// Adds pictures, files, the deformed CT and warnings.
void add_outputs(Json& report, const RunFacts& facts);

/// Text of a report, with plain_text in every key and value.
std::string json_text(const Json& report, int indent = 1);
/// Standalone page with embedded pictures of `folder` and curves. `motion` is HTML for the 3D view of the
/// run.
std::string report_html(const Json& report, const std::filesystem::path& folder,
                        const std::string& motion = {});

}  // namespace turgor

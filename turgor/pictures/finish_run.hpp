// End of a run: results first, pictures second. The folder of results gets its final name before anything is
// drawn. Pictures are drawn into a hidden folder beside it and added when all are drawn, so that a program
// that ends while it draws loses nothing else.
#pragma once

#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/pictures/outputs.hpp"
#include "turgor/pictures/run_scene.hpp"
#include "turgor/sim/output_folder.hpp"

namespace turgor {

/// A finished simulation or replay, and its outputs so far.
struct FinishedRun {
  const World& world;
  const WorldSnapshot& snapshot;            // the last
  const std::vector<Pressed>& pressed;      // under the largest forces
  const std::vector<WorldSnapshot>& later;  // snapshots whose frames are not drawn yet
  Outputs& outputs;
};

/// Writes all files, report and page, and gives the folder its final name.
Status commit_results(const Timer& total, const FinishedRun& run, const Json& report, OutputFolder& folder,
                      const RunCallbacks& callbacks);

/// Draws, then adds pictures, videos, and report and page with them, to the committed results.
Status add_pictures_to_results(const Timer& total, const FinishedRun& run, Json& report,
                               const OutputFolder& folder, const RunCallbacks& callbacks);

}  // namespace turgor

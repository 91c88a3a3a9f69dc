// Heights of a rough surface: a grid of samples that repeats, with cubic curves between them [Catmull, Rom
// 1974], so that slopes are continuous. A map of one row is a profile along a path.
#pragma once

#include <array>
#include <vector>

namespace turgor::contact {

struct HeightMap {
  int columns = 0, rows = 0;   // at least 1 each
  double spacing = 1e-4;       // of the samples [m]
  std::vector<double> height;  // rows of `columns` [m]
  double curvature = 0;        // largest second derivative in any direction [1/m]
  double range = 0;            // highest minus lowest sample [m]
};

/// A map with its curvature and range. `height`: columns · rows.
HeightMap make_height_map(int columns, int rows, double spacing, std::vector<double> height);

/// Height and its derivatives along columns (u) and rows (v).
struct HeightSample {
  double height = 0;              // [m]
  double u = 0, v = 0;            // [1]
  double uu = 0, uv = 0, vv = 0;  // [1/m]
};
/// `u`, `v`: any position; the map repeats [m].
HeightSample sample_height(const HeightMap& map, double u, double v);

}  // namespace turgor::contact

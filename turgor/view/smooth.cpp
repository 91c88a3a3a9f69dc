#include "turgor/view/smooth.hpp"

#include <algorithm>

namespace turgor {

namespace {

// Mean of 2 × 2 × 2 samples; border samples are repeated.
struct HalveRow {
  const CtVolume& ct;
  CtVolume& half;

  void operator()(std::size_t row) const {
    const Int3 n = ct.grid.size;
    const int j = 2 * (int(row) % half.grid.size.y), k = 2 * (int(row) / half.grid.size.y);
    std::vector<int> sum(std::size_t(n.x) + 1, 0);
    for (int corner = 0; corner < 4; corner++) {
      const int v = std::min(j + (corner & 1), n.y - 1), w = std::min(k + (corner >> 1), n.z - 1);
      const std::int16_t* samples = &ct.samples[sample_index(ct.grid, 0, v, w)];
      for (std::size_t i = 0; i < std::size_t(n.x); i++) sum[i] += samples[i];
    }
    sum.back() = sum[std::size_t(n.x) - 1];
    std::int16_t* out = &half.samples[row * std::size_t(half.grid.size.x)];
    for (std::size_t i = 0; i < std::size_t(half.grid.size.x); i++)
      out[i] = std::int16_t((sum[2 * i] + sum[2 * i + 1]) / 8);
  }
};

// Weights 1 2 1 along all three axes at once: nine rows are summed, then neighbors in the sum.
struct SmoothRow {
  const CtVolume& in;
  CtVolume& out;

  void operator()(std::size_t row) const {
    const Int3 n = in.grid.size;
    const int j = int(row) % n.y, k = int(row) / n.y;
    std::vector<int> sum(std::size_t(n.x), 0);
    for (int dk = -1; dk <= 1; dk++) {
      for (int dj = -1; dj <= 1; dj++) {
        const int weight = (2 - std::abs(dj)) * (2 - std::abs(dk));
        const int v = std::clamp(j + dj, 0, n.y - 1), w = std::clamp(k + dk, 0, n.z - 1);
        const std::int16_t* samples = &in.samples[sample_index(in.grid, 0, v, w)];
        for (std::size_t i = 0; i < std::size_t(n.x); i++) sum[i] += weight * samples[i];
      }
    }
    std::int16_t* result = &out.samples[row * std::size_t(n.x)];
    for (std::size_t i = 0; i < std::size_t(n.x); i++) {
      const int left = sum[i > 0 ? i - 1 : 0], right = sum[std::min(i + 1, std::size_t(n.x) - 1)];
      result[i] = std::int16_t((left + 2 * sum[i] + right) / 64);
    }
  }
};

}  // namespace

CtVolume smooth_half(const Exec& exec, const CtVolume& ct) {
  CtVolume half{ct.grid, {}};
  Grid& grid = half.grid;
  grid.origin = point_at(ct.grid, {0.5, 0.5, 0.5});
  grid.spacing *= 2;
  grid.size = {(ct.grid.size.x + 1) / 2, (ct.grid.size.y + 1) / 2, (ct.grid.size.z + 1) / 2};
  half.samples.resize(sample_count(grid));
  const std::size_t rows = std::size_t(grid.size.y) * std::size_t(grid.size.z);
  parallel_for(exec, rows, HalveRow{ct, half}, 16);
  CtVolume smooth{grid, std::vector<std::int16_t>(half.samples.size())};
  parallel_for(exec, rows, SmoothRow{half, smooth}, 16);
  return smooth;
}

}  // namespace turgor

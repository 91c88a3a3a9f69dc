#include "turgor/models/cloth/contact/spatial_hash.hpp"

#include <bit>

#include "turgor/core/assert.hpp"
#include "turgor/models/cloth/model/contacts.hpp"

namespace turgor::cloth {

void sort_points(const Exec& exec, const Vectors& points, int count, Real cell, SpatialHash& near) {
  TURGOR_CHECK(count >= 0 && std::size_t(count) <= points.size(), "the points to sort are given");
  TURGOR_CHECK(cell > 0, "a cell has a size");
  // sizes
  const auto n = std::size_t(count);
  const std::size_t buckets = std::bit_ceil(std::max<std::size_t>(n, 64));
  near.cell = cell;
  near.mask = std::uint32_t(buckets - 1);
  near.bucket.resize(n), near.index.resize(n);
  for (auto* list : {&near.x, &near.y, &near.z}) list->resize(n + std::size_t(kLanes));
  // bucket of each point
  const Real inverse = 1 / cell;
  parallel_for(
      exec, n,
      [&](std::size_t i) {
        const Vec3 p = points[i];
        const std::uint32_t row = row_bucket(cell_of(p.y, inverse), cell_of(p.z, inverse));
        near.bucket[i] = int((row + std::uint32_t(cell_of(p.x, inverse))) & near.mask);
      },
      4096);
  near.begin.assign(
      buckets + 2,
      0);  // Counting sort by bucket; shifted by one: begin[b + 1] runs through bucket b while it is filled.
  for (const int b : near.bucket) near.begin[std::size_t(b) + 2]++;
  for (std::size_t b = 2; b < near.begin.size(); b++) near.begin[b] += near.begin[b - 1];
  for (std::size_t i = 0; i < n; i++) {
    const auto at = std::size_t(near.begin[std::size_t(near.bucket[i]) + 1]++);
    near.index[at] = int(i);
    near.x[at] = points.x[i], near.y[at] = points.y[i], near.z[at] = points.z[i];
  }
}

}  // namespace turgor::cloth

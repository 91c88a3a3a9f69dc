#include "turgor/geometry/dilate.hpp"

#include <algorithm>

#include "turgor/core/config.hpp"

namespace turgor {

namespace {

/// One axis of the box, one layer of the mask at a time.
struct DilateAlong {
  const std::vector<std::uint8_t>& from;
  Int3 size;
  int axis, reach;
  std::uint8_t* to;  // a copy of `from`

  std::ptrdiff_t row(Int3 p) const { return (std::ptrdiff_t(p.z) * size.y + p.y) * size.x; }

  void operator()(std::size_t k) const {
    for (int j = 0; j < size.y; j++)
      for (int d = -reach; d <= reach; d++) {
        Int3 other{0, j, int(k)};
        if (axis > 0) other[axis] += d;
        if (other[axis] < 0 || other[axis] >= size[axis]) continue;
        const int shift = axis == 0 ? d : 0;
        const int begin = std::max(0, -shift), end = std::min(size.x, size.x - shift);
        std::uint8_t* out = to + row({0, j, int(k)});
        const std::uint8_t* in = from.data() + row(other) + shift;
        TURGOR_LANES
        for (int i = begin; i < end; i++) out[i] |= in[i];
      }
  }
};

}  // namespace

void dilate(const Exec& exec, std::vector<std::uint8_t>& mask, Int3 size, int reach) {
  for (int axis = 0; axis < 3; axis++) {
    const std::vector<std::uint8_t> from = mask;
    parallel_for(exec, std::size_t(size.z), DilateAlong{from, size, axis, reach, mask.data()});
  }
}

}  // namespace turgor

// Cuts and stitches by the caller.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include "bindings.hpp"

namespace turgor {

using namespace nb::literals;

namespace {

using Points = nb::ndarray<const double, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;

std::vector<Vec3d> points_of(const Points& rows) {
  std::vector<Vec3d> points;
  for (std::size_t n = 0; n < rows.shape(0); n++) {
    const double* p = rows.data() + 3 * n;
    points.push_back({p[0], p[1], p[2]});
  }
  return points;
}

std::string cut(PyWorld& world, const std::string& body, const Points& points, double depth, double tilt,
                double duration, const std::string& name) {
  return world.cut({.body = named_body(world, body),
                    .name = name,
                    .points = points_of(points),
                    .depth = depth,
                    .tilt = tilt,
                    .duration = duration});
}

std::string stitch(PyWorld& world, const std::string& body, const Points& points, const std::string& wound,
                   const std::string& thread, std::optional<double> tension, double duration) {
  return world.stitch({.body = named_body(world, body),
                       .wound = wound,
                       .points = points_of(points),
                       .thread = thread,
                       .tension = tension,
                       .duration = duration});
}

}  // namespace

void bind_by_hand(nb::class_<PyWorld>& world) {
  world.def("_cut", &cut, "body"_a, "points"_a, "depth"_a, "tilt"_a, "duration"_a, "name"_a)
      .def("_stitch", &stitch, "body"_a, "points"_a, "wound"_a, "thread"_a, "tension"_a.none(), "duration"_a)
      .def("_tighten", &PyWorld::tighten, "stitch"_a, "tension"_a.none(), "duration"_a);
}

}  // namespace turgor

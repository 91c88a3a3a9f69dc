#include "mpi/scene.hpp"

#include <fmt/format.h>

namespace turgor::mpi {

namespace {

/// A key, whether the scene asks for what it must not, and what is expected instead.
struct Refusal {
  bool asked;
  const char* key;
  const char* expected;
};

Status check(const std::string& place, std::initializer_list<Refusal> refusals) {
  for (const Refusal& r : refusals)
    if (r.asked) return Error{fmt::format("{}.{}: several processes share {}", place, r.key, r.expected)};
  return Done{};
}

Status check_body(const LatticeScene& body) {
  using lattice::TissueLaw, lattice::Ordering;
  const lattice::Params& params = body.params;
  const bool solid = params.tissue.law == TissueLaw::kSolid;
  return check(
      body.place,
      {{params.solver.ordering == Ordering::kColors, "solver.schedule",
        "a sweep by slabs of layers: expected \"slabs\""},
       {params.solver.sleep > 0, "solver.sleep", "bodies that are awake: expected 0"},
       {solid && params.solver.coarse, "solver.coarse",
        "sweeps, not the coarse space beside them that solid tissue has otherwise: expected coarse = false"},
       {!body.labels.empty(), "labels", "a body that Hounsfield units tell apart: expected no segmentation"},
       {body.only > 0, "only", "all of a CT: expected no label alone"},
       {!params.tissue.young_of_label.empty(), "tissue.labels",
        "a body that Hounsfield units tell apart: expected no moduli by label"},
       {!body.direction_field.empty(), "skin.direction_field",
        "one direction of Langer's lines: expected skin.direction"},
       {body.held.has_value(), "fixed",
        "what bone and the ends hold: expected \"bone\", \"ends\" or \"none\""},
       {!body.ct.series.empty(), "series", "a file of slices: expected no series of DICOM"}});
}

}  // namespace

Status check_scene(const Scene& scene) {
  const std::string file = scene.file.string();
  if (scene.lattice_bodies.size() != 1 || !scene.sfem_bodies.empty() || !scene.rhombus_bodies.empty() ||
      !scene.cloth_bodies.empty())
    return Error{fmt::format(
        "{}: body: several processes share one body: expected a lattice alone, found {} of model \"lattice\" "
        "and {} of others",
        file, scene.lattice_bodies.size(),
        scene.sfem_bodies.size() + scene.rhombus_bodies.size() + scene.cloth_bodies.size())};
  if (scene.device == Device::kGpu)
    return Error{file +
                 ": world.device: several processes share a body that steps on CPUs: expected \"cpu\""};
  if (!scene.tools.empty())
    return Error{
        fmt::format("{}: tool: several processes share a body that nothing touches: expected no tools, "
                    "found {}",
                    file, scene.tools.size())};
  if (const Status body = check_body(scene.lattice_bodies[0]); !body) return body;
  for (const IncisionScene& incision : scene.incisions)
    if (const Status cut =
            check(incision.place, {{incision.by_fraction, "from_fraction",
                                    "no box of their body: expected from and to, or path, in metres"},
                                   {incision.blade.width > 0, "width", "cuts of edges: expected no width"}});
        !cut)
      return cut;
  return check(file + ": output",
               {{!scene.output.deformed_ct.empty(), "deformed_ct", "no CT to write: expected none"},
                {!scene.output.jacobian.empty(), "jacobian", "no CT to write: expected none"},
                {!scene.output.displacement.empty(), "displacement",
                 "no CT to write it on: expected none; displacement.mhd is written at the nodes"}});
}

}  // namespace turgor::mpi

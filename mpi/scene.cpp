#include "mpi/scene.hpp"

#include <fmt/format.h>

namespace turgor::mpi {

namespace {

/// A check of a scene: true if the value is refused, its key, and the expected value.
struct Refusal {
  bool refused;
  const char* key;
  const char* expected;
};

Status check(const std::string& location, std::initializer_list<Refusal> refusals) {
  for (const Refusal& r : refusals)
    if (r.refused) return Error{fmt::format("{}.{}: several processes {}", location, r.key, r.expected)};
  return Done{};
}

Status check_body(const LatticeScene& body) {
  using lattice::TissueLaw, lattice::Ordering;
  const lattice::Params& params = body.params;
  const bool solid = params.tissue.law == TissueLaw::kSolid;
  return check(
      body.source_location,
      {{params.solver.ordering == Ordering::kColors, "solver.ordering",
        "need sweeps by slabs: expected \"slabs\""},
       {params.solver.sleep_speed > 0, "solver.sleep_speed", "do not support sleep: expected 0"},
       {solid && params.solver.coarse, "solver.coarse",
        "do not support the coarse space, the default of solid tissue: expected coarse = false"},
       {!body.labels.empty(), "labels", "classify tissue by Hounsfield units: expected no segmentation"},
       {body.only > 0, "only", "simulate the whole CT: expected no label"},
       {!params.tissue.young_of_label.empty(), "tissue.labels",
        "classify tissue by Hounsfield units: expected no moduli by label"},
       {!body.direction_field.empty(), "skin.direction_field",
        "need one direction of Langer's lines: expected skin.direction"},
       {body.held.has_value(), "fixed",
        "can fix only bone and the ends: expected \"bone\", \"ends\" or \"none\""},
       {body.stiffness_scale != 1, "stiffness_scale", "take moduli from `tissue`: expected 1"},
       {!body.ct.series.empty(), "series", "read slices of one file: expected no series of DICOM"}});
}

}  // namespace

Status check_scene(const Scene& scene) {
  const std::string file = scene.file.string();
  const std::size_t others = scene.sfem_bodies.size() + scene.rhombus_bodies.size() +
                             scene.cloth_bodies.size() + scene.rigid_bodies.size();
  if (scene.lattice_bodies.size() != 1 || others > 0)
    return Error{fmt::format(
        "{}: body: several processes simulate one body: expected one lattice, found {} of model \"lattice\" "
        "and {} of others",
        file, scene.lattice_bodies.size(), others)};
  if (!scene.attachments.empty() || !scene.body_contacts.empty())
    return Error{
        fmt::format("{}: {}: several processes do not support what bodies hold and touch: expected none",
                    file, scene.attachments.empty() ? "contact" : "attachment")};
  if (scene.device == Device::kGpu)
    return Error{file + ": world.device: several processes use CPUs: expected \"cpu\""};
  if (!scene.tools.empty())
    return Error{
        fmt::format("{}: tool: several processes do not support touches: expected no tools, "
                    "found {}",
                    file, scene.tools.size())};
  if (!scene.sutures.empty())
    return Error{
        fmt::format("{}: suture: several processes do not support stitches: expected no sutures, found {}",
                    file, scene.sutures.size())};
  if (const Status body = check_body(scene.lattice_bodies[0]); !body) return body;
  for (const IncisionScene& incision : scene.incisions)
    if (const Status cut =
            check(incision.source_location,
                  {{incision.by_fraction, "from_fraction",
                    "do not support fractions of the body's box: expected from and to, or path, in meters"},
                   {incision.blade.excision.has_value(), "depth",
                    "do not support excisions: expected incisions only"},
                   {incision.blade.width > 0, "width", "cut edges only: expected no width"}});
        !cut)
      return cut;
  return check(file + ": output",
               {{!scene.output.deformed_ct.empty(), "deformed_ct", "write no CT: expected none"},
                {!scene.output.jacobian.empty(), "jacobian", "write no CT: expected none"},
                {!scene.output.displacement.empty(), "displacement",
                 "write displacement.mhd at the nodes: expected none"}});
}

}  // namespace turgor::mpi

#include "turgor/sim/report/report_lattice.hpp"

#include <cstdint>

#include "turgor/core/hash.hpp"
#include "turgor/core/plain_text.hpp"
#include "turgor/models/lattice/coarse/coarse_correction.hpp"
#include "turgor/models/lattice/model/fields.hpp"
#include "turgor/models/lattice/model/moving_mass.hpp"
#include "turgor/models/lattice/solver/viscosity.hpp"
#include "turgor/sim/report/section.hpp"
#include "turgor/sim/scene/scene_cells.hpp"

namespace turgor {

namespace {

using namespace units;

Json of_size(Int3 v) { return Json::array({v.x, v.y, v.z}); }
Json of_mm(Vec3d v) { return numbers({v.x * kMm, v.y * kMm, v.z * kMm}); }

struct LatticeInput {
  const LatticeScene& scene;
  const LatticeBody& body;
  std::size_t bytes;
};

/// Bytes of each field that has any; together those of the body.
Json memory_of_fields(const LatticeBody& body) {
  Json bytes;
  const auto add = [&](const Field& field, const auto& values) {
    if (const std::size_t size = field_bytes(values); size > 0) bytes[field.name] = size;
  };
  const lattice::State& state = body.state;
  lattice::visit_fields(body.model, add);
  lattice::visit_fields(state, add);
  if (const auto& coarse = state.workspace.coarse) bytes["coarse_space"] = lattice::memory_bytes(*coarse);
  return bytes;
}

/// Text of a DICOM element of the study; absent if the CT has none.
Json dicom_text(const LatticeInput& l, std::uint32_t tag) {
  const auto found = l.body.ct_origin.elements.find(tag);
  std::string text = found == l.body.ct_origin.elements.end() ? "" : found->second;
  while (!text.empty() && (text.back() == ' ' || text.back() == '\0')) text.pop_back();
  return text.empty() ? absent() : Json(plain_text(text));
}

const Quantity<LatticeInput> kLattice[] = {
    {"name", kNone, "", [](const LatticeInput& l) -> Json { return l.body.name; }, kInReport},
    {"model", kNone, "", [](const LatticeInput&) -> Json { return model_name(BodyKind::kLattice); },
     kInReport},
    {"ct.source", kNone, "source",
     [](const LatticeInput& l) -> Json { return l.scene.ct.phantom ? "phantom" : l.scene.ct.file.string(); }},
    {"ct.patient", kNone, "", [](const LatticeInput& l) { return dicom_text(l, 0x00100010); }, kInReport},
    {"ct.patient_id", kNone, "", [](const LatticeInput& l) { return dicom_text(l, 0x00100020); }, kInReport},
    {"ct.study", kNone, "", [](const LatticeInput& l) { return dicom_text(l, 0x00081030); }, kInReport},
    {"ct.study_date", kNone, "", [](const LatticeInput& l) { return dicom_text(l, 0x00080020); }, kInReport},
    {"ct.series", kNone, "",
     [](const LatticeInput& l) { return l.body.ct_series.empty() ? absent() : Json(l.body.ct_series); },
     kInReport},
    {"ct.size", kNone, "", [](const LatticeInput& l) { return of_size(l.body.ct.grid.size); }, kInReport},
    {"ct.spacing_mm", kNone, "", [](const LatticeInput& l) { return of_mm(l.body.ct.grid.spacing); },
     kInReport},
    {"ct.content_hash", kNone, "", [](const LatticeInput& l) -> Json { return hash_text(l.body.ct_hash); },
     kInReport},
    {"lattice_size", kNone, "",
     [](const LatticeInput& l) { return of_size(l.body.model.anatomy.lattice.size); }, kInReport},
    {"lattice_spacing_mm", kNone, "",
     [](const LatticeInput& l) { return of_mm(Vec3d(l.body.model.anatomy.lattice.spacing)); }, kInReport},
    {"nodes", kCount, "",
     [](const LatticeInput& l) -> Json { return node_count(l.body.model.anatomy.lattice); }, kInReport},
    {"body_nodes", kCount, "nodes of the body",
     [](const LatticeInput& l) -> Json { return l.body.model.anatomy.body_nodes; }, kEverywhere},
    {"free_nodes", kCount, "free nodes",
     [](const LatticeInput& l) -> Json { return l.body.model.anatomy.free_nodes; }},
    {"moving_mass", kGrams, "mass of the free nodes",
     [](const LatticeInput& l) -> Json { return lattice::moving_mass(l.body.model.anatomy); }},
    {"skin_triangles", kCount, "skin triangles",
     [](const LatticeInput& l) -> Json { return l.body.model.anatomy.skin.triangles.size(); }, kEverywhere},
    {"surface_cells", kNone, "cells at the surface",
     [](const LatticeInput& l) -> Json { return cells_text(l.scene); }, kEverywhere},
    {"method", kNone, "solver",
     [](const LatticeInput& l) -> Json {
       return l.scene.params.solver.method == lattice::Method::kPbd ? "pbd" : "vbd";
     }},
    {"ordering", kNone, "ordering of a sweep",
     [](const LatticeInput& l) -> Json {
       return l.scene.params.solver.ordering == lattice::Ordering::kColors ? "colors" : "slabs";
     }},
    {"device", kNone, "",
     [](const LatticeInput& l) -> Json { return l.body.state.has_device() ? "gpu" : "cpu"; }, kInReport},
    {"sweeps", kCount, "sweeps", [](const LatticeInput& l) -> Json { return l.scene.params.solver.sweeps; }},
    {"rows_asleep", kNone, "fraction of rows asleep, over the run",
     [](const LatticeInput& l) -> Json {
       return l.body.row_steps > 0 ? Json(double(l.body.row_steps_asleep) / double(l.body.row_steps))
                                   : absent();
     }},
    {"memory", kBytes, "", [](const LatticeInput& l) -> Json { return l.bytes; }, kInReport},
    {"memory_bytes_per_node",
     {"", "bytes/node"},
     "memory",
     [](const LatticeInput& l) -> Json { return double(l.bytes) / node_count(l.body.model.anatomy.lattice); },
     kEverywhere},
    {"memory_bytes_by_field", kNone, "", [](const LatticeInput& l) { return memory_of_fields(l.body); },
     kInReport},
    {"set_max", kPercent, "largest permanent strain",
     [](const LatticeInput& l) -> Json {
       return lattice::has_set(l.body.model.params.tissue.set)
                  ? Json(lattice::largest_set(Exec(1), l.body.model, l.body.state))
                  : absent();
     },
     kEverywhere},
    {"read", kSeconds, "reading the CT", [](const LatticeInput& l) -> Json { return l.body.read_seconds; }},
    {"build", kSeconds, "building the body",
     [](const LatticeInput& l) -> Json { return l.body.build_seconds; }},
    {"state_hash", kNone, "state hash",
     [](const LatticeInput& l) -> Json {
       return hash_text(lattice::state_hash(l.body.model, l.body.state));
     }},
};

using C = CutMeasures;
using Piece = lattice::Specimen;

Json of_excision(const C& cut, double value) { return cut.excision ? Json(value) : absent(); }
/// Relative change of the wound after the piece left.
Json of_change(const C& cut, double now, double marked) {
  return cut.specimen && marked > 0 ? Json(now / marked - 1) : absent();
}
Json of_specimen(const C& cut, double (*value)(const Piece&)) {
  return cut.specimen ? Json(value(*cut.specimen)) : absent();
}

const Quantity<C> kWound[] = {
    {"name", kNone, "", [](const C& c) -> Json { return c.name; }, kInReport},
    {"body", kNone, "", [](const C& c) -> Json { return c.body; }, kInReport},
    {"kind", kNone, "",
     [](const C& c) -> Json { return c.region     ? "region"
                                     : c.excision ? "excision"
                                                  : "edges"; }, kInReport},
    {"angle_to_lines", kDegrees, "angle to Langer's lines",
     [](const C& c) -> Json { return c.tension.is_directional ? Json(c.tension.angle) : absent(); },
     kEverywhere},
    {"tension_across_cut", kTension, "skin tension across the cut",
     [](const C& c) -> Json { return c.tension.opening; }, kEverywhere},
    {"tension_along_cut", kTension, "skin tension along the cut",
     [](const C& c) -> Json { return c.tension.lengthwise; }},
    {"depth", kMillimeters, "depth", [](const C& c) -> Json { return c.depth; }},
    {"width", kMillimeters, "", [](const C& c) -> Json { return c.width; }, kInReport},
    {"undermined.width", kMillimeters, "undermined on each side",
     [](const C& c) -> Json { return c.undermined.width > 0 ? Json(c.undermined.width) : absent(); },
     kEverywhere},
    {"undermined.depth", kMillimeters, "… at a depth of",
     [](const C& c) -> Json { return c.undermined.width > 0 ? Json(c.undermined.depth) : absent(); }},
    {"length", kMillimeters, "length of the cut skin", [](const C& c) -> Json { return c.wound.length; },
     kEverywhere},
    {"gape_max", kMillimeters, "gape, largest", [](const C& c) -> Json { return c.wound.gape_max; },
     kEverywhere, "gape of {}"},
    {"gape_error_expected", kPercent, "… expected error from the spacing",
     [](const C& c) -> Json { return c.gape_error >= 0 ? Json(c.gape_error) : absent(); }, kEverywhere},
    {"gape_mean", kMillimeters, "gape, mean", [](const C& c) -> Json { return c.wound.gape_mean; },
     kEverywhere},
    {"opening_area", kSquareMillimeters, "opening area",
     [](const C& c) -> Json { return c.wound.opening_area; }, kEverywhere},
    {"edge_displacement", kMillimeters, "displacement of the lips",
     [](const C& c) -> Json { return c.wound.edge_displacement; }},
    {"marked.length", kMillimeters, "length of the marked skin",
     [](const C& c) { return of_excision(c, c.marked.length); }, kEverywhere},
    {"marked.width", kMillimeters, "width of the marked skin",
     [](const C& c) { return of_excision(c, c.marked.width); }, kEverywhere},
    {"marked.area", kSquareMillimeters, "area of the marked skin",
     [](const C& c) { return of_excision(c, c.marked.area); }},
    {"change.length", kPercent, "wound against the marked skin, length",
     [](const C& c) { return of_change(c, c.wound.length, c.marked.length); }, kEverywhere},
    {"change.width", kPercent, "wound against the marked skin, width",
     [](const C& c) { return of_change(c, c.wound.gape_max, c.marked.width); }, kEverywhere},
    {"change.area", kPercent, "wound against the marked skin, area",
     [](const C& c) { return of_change(c, c.wound.opening_area, c.marked.area); }},
    {"specimen.mass", kGrams, "mass of the specimen",
     [](const C& c) { return of_specimen(c, [](const Piece& s) { return s.mass; }); }, kEverywhere},
    {"specimen.volume", kMillilitres, "volume of the specimen",
     [](const C& c) { return of_specimen(c, [](const Piece& s) { return s.volume; }); }},
    {"specimen.length", kMillimeters, "length of the specimen",
     [](const C& c) { return of_specimen(c, [](const Piece& s) { return s.free.length; }); }},
    {"specimen.width", kMillimeters, "width of the specimen",
     [](const C& c) { return of_specimen(c, [](const Piece& s) { return s.free.width; }); }},
    {"specimen.area", kSquareMillimeters, "area of the specimen",
     [](const C& c) { return of_specimen(c, [](const Piece& s) { return s.free.area; }); }},
    {"specimen.length_change", kPercent, "shrinkage of the specimen, length",
     [](const C& c) {
       return of_specimen(c, [](const Piece& s) { return s.free.length / s.in_place.length - 1; });
     },
     kEverywhere},
    {"specimen.width_change", kPercent, "shrinkage of the specimen, width",
     [](const C& c) {
       return of_specimen(c, [](const Piece& s) { return s.free.width / s.in_place.width - 1; });
     },
     kEverywhere},
    {"specimen.area_change", kPercent, "shrinkage of the specimen, area",
     [](const C& c) {
       return of_specimen(c, [](const Piece& s) { return s.free.area / s.in_place.area - 1; });
     }},
    {"dog_ear.first", kMillimeters, "dog ear at the first end",
     [](const C& c) -> Json { return c.dog_ears ? Json(c.dog_ears->first) : absent(); }},
    {"dog_ear.last", kMillimeters, "dog ear at the last end",
     [](const C& c) -> Json { return c.dog_ears ? Json(c.dog_ears->last) : absent(); }},
    {"edges_cut", kCount, "lattice edges cut",
     [](const C& c) -> Json { return c.region ? absent() : Json(c.edges); }},
    {"nodes_removed", kCount, "lattice nodes removed",
     [](const C& c) -> Json { return c.region ? Json(c.edges) : absent(); }},
};

using W = WoundSample;
const Quantity<W> kWoundSeries[] = {
    {"time", kSeconds, "time", [](const W& s) -> Json { return s.time; }},
    {"gape_max", kMillimeters, "largest gape", [](const W& s) -> Json { return s.gape_max; }},
    {"gape_mean", kMillimeters, "mean gape", [](const W& s) -> Json { return s.gape_mean; }},
    {"opening_area", kSquareMillimeters, "opening area", [](const W& s) -> Json { return s.opening_area; }},
    {"edge_displacement", kMillimeters, "displacement of the lips",
     [](const W& s) -> Json { return s.edge_displacement; }},
};

using G = lattice::GapePoint;
const Quantity<G> kProfile[] = {
    {"along", kMillimeters, "along the cut", [](const G& p) -> Json { return p.along; }},
    {"gape", kMillimeters, "gape", [](const G& p) -> Json { return p.gape; }},
};

const Quantity<SolverSample> kSolver[] = {
    {"time", kSeconds, "time", [](const SolverSample& s) -> Json { return s.time; }},
    {"residual_largest", kNewtons, "largest",
     [](const SolverSample& s) -> Json { return s.residual.largest; }},
    {"residual_rms", kNewtons, "root mean square",
     [](const SolverSample& s) -> Json { return s.residual.rms; }},
    {"residual_before", kNewtons, "root mean square before the sweeps",
     [](const SolverSample& s) -> Json { return s.residual.before; }},
    {"energy", kJoules, "energy", [](const SolverSample& s) -> Json { return s.energy; }},
    {"largest_speed", kSpeed, "largest speed", [](const SolverSample& s) -> Json { return s.largest_speed; }},
};

using D = DeformedCtReport;
const Quantity<D> kDeformed[] = {
    {"body", kNone, "of", [](const D& d) -> Json { return d.body; }},
    {"file", kNone, "file", [](const D& d) -> Json { return d.file; }},
    {"size", kNone, "", [](const D& d) { return of_size(d.size); }, kInReport},
    {"resample", kSeconds, "resampling", [](const D& d) -> Json { return d.seconds; }},
    {"mass_error", kNone, "relative error of mass", [](const D& d) -> Json { return d.mass_error; }},
    {"inverted_tetrahedra", kCount, "inverted tetrahedra", [](const D& d) -> Json { return d.folds; }},
};

}  // namespace

Json report_body(const ReportInput&, const LatticeScene& scene, const LatticeBody& body, BodyId) {
  const LatticeInput input{scene, body, lattice::memory_bytes(body.model, body.state)};
  return values_of(kLattice, input);
}

Json wound_report(const CutMeasures& cut) {
  Json json = values_of(kWound, cut);
  add_rows(json, "profile_columns", "profile", kProfile, cut.wound.profile);
  add_rows(json, "series_columns", "series", kWoundSeries, cut.series);
  return json;
}

namespace {

/// Ratio of the residual after the sweeps to that before, over snapshots with motion; null without motion.
/// Below 0.1 the transient of a wound is accurate to about 10 %. Above, only its equilibrium is.
Json residual_ratio(const Measures& measures) {
  constexpr double kMoves = 1e-3;  // [m/s]
  double after = 0, before = 0;
  for (const SolverSample& sample : measures.solver)
    if (sample.largest_speed > kMoves) after += sample.residual.rms, before += sample.residual.before;
  return before > 0 ? Json(after / before) : Json();
}

}  // namespace

Json solver_report(const Measures& measures) {
  Json json{{"residual_by_sweeps", residual_ratio(measures)}};
  add_rows(json, "columns", "samples", kSolver, measures.solver);
  return json;
}

Json deformed_report(const DeformedCtReport& deformed) { return values_of(kDeformed, deformed); }

Section wound_section() {
  return {"Measures",          "wound", [](const Json& report) { return items_of(report, "wounds"); },
          captions_of(kWound), false,   true};
}
Section lattice_section() {
  return {"Lattices", "body", [](const Json& report) { return bodies_of(report, BodyKind::kLattice); },
          captions_of(kLattice)};
}
Section deformed_section() {
  return {"The deformed CT", "CT", [](const Json& report) { return items_of(report, "deformed_ct"); },
          captions_of(kDeformed)};
}

}  // namespace turgor

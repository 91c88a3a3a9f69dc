#include "turgor/sim/report/report_rhombus.hpp"

#include <numbers>

#include "turgor/core/timing.hpp"
#include "turgor/sim/report/section.hpp"
#include "turgor/sim/scene/tissue_presets.hpp"

namespace turgor {

namespace {

struct SurfaceSourceText {
  std::string operator()(const SurfaceFile& s) const { return s.file.string(); }
  std::string operator()(const PhantomLiverSurface&) const { return "phantom liver"; }
  std::string operator()(const SurfaceOfBody&) const { return "the surface of another body"; }
};

using namespace units;

struct RhombusInput {
  const RhombusScene& scene;
  const RhombusBody& body;
  const Pressed& pressed;
};
using R = RhombusInput;

const Quantity<R> kRhombus[] = {
    {"name", kNone, "", [](const R& r) -> Json { return r.body.name; }, kInReport},
    {"model", kNone, "", [](const R&) -> Json { return model_name(BodyKind::kRhombus); }, kInReport},
    {"source", kNone, "source",
     [](const R& r) -> Json { return std::visit(SurfaceSourceText{}, r.scene.source); }},
    {"tissue", kNone, "tissue", [](const R& r) -> Json { return r.scene.tissue; }},
    {"tissue_source", kNone, "",
     [](const R& r) -> Json {
       const TissuePreset* tissue = find_preset(r.scene.tissue, PresetKind::kChain);
       return tissue ? tissue->source : "";
     },
     kInReport},
    {"vertices", kCount, "vertices", [](const R& r) -> Json { return r.body.model.surface.vertices.size(); },
     kEverywhere},
    {"triangles", kCount, "triangles",
     [](const R& r) -> Json { return r.body.model.surface.triangles.size(); }},
    {"volume", kMillilitres, "volume", [](const R& r) -> Json { return r.body.volume; }, kEverywhere},
    {"normal", kTension, "k_N", [](const R& r) -> Json { return r.scene.params.chain.normal; }},
    {"tangential", kTension, "k_T of the first unit",
     [](const R& r) -> Json { return r.scene.params.chain.tangential; }},
    {"decay", kNone, "β", [](const R& r) -> Json { return r.scene.params.chain.decay; }},
    {"angle", kDegrees, "θ",
     [](const R& r) -> Json { return r.scene.params.chain.angle * 180 / std::numbers::pi; }},
    {"side", kMillimeters, "side of the rhombi",
     [](const R& r) -> Json { return r.scene.params.chain.side; }},
    {"bulge", kNone, "bulging fraction of the indented volume",
     [](const R& r) -> Json { return r.scene.params.bulge; }},
    {"memory", kBytes, "memory",
     [](const R& r) -> Json { return rhombus::memory_bytes(r.body.model, r.body.state); }},
    {"build", kSeconds, "building", [](const R& r) -> Json { return r.body.build_seconds; }},
    {"surface_p50", kMilliseconds, "surface for a picture, median",
     [](const R& r) -> Json { return percentile(r.pressed.surface_seconds, 0.5); }},
    {"pressed_volume", kMillilitres, "indented volume, largest",
     [](const R& r) -> Json { return r.body.pressed_volume; }},
    {"force_max", kNewtons, "", [](const R& r) -> Json { return r.pressed.force; }, kInReport},
    {"force_max_at", kSeconds, "", [](const R& r) -> Json { return r.pressed.time; }, kInReport},
    {"jump_per_10_um", kNewtons, "largest jump of a force per 10 µm",
     [](const R& r) -> Json { return r.body.jump; }},
    {"jump_at", kSeconds, "… at", [](const R& r) -> Json { return r.body.jump_at; }},
};

}  // namespace

Json report_body(const ReportInput& input, const RhombusScene& scene, const RhombusBody& body, BodyId id) {
  return values_of(kRhombus, RhombusInput{scene, body, pressed_body(input.measures.pressed, id)});
}

Section rhombus_section() {
  return {"Bodies of rhombus chains", "body",
          [](const Json& report) { return bodies_of(report, BodyKind::kRhombus); }, captions_of(kRhombus)};
}

}  // namespace turgor

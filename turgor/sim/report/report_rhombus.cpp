#include "turgor/sim/report/report_rhombus.hpp"

#include <numbers>

#include "turgor/core/timing.hpp"
#include "turgor/models/rhombus/tissues.hpp"
#include "turgor/sim/report/json_numbers.hpp"

namespace turgor {

namespace {

struct SourceText {
  std::string operator()(const SurfaceFile& s) const { return s.file.string(); }
  std::string operator()(const PhantomLiverSurface&) const { return "phantom liver"; }
  std::string operator()(const SurfaceOfBody&) const { return "the surface of another body"; }
};

}  // namespace

Json report_body(const ReportInput& input, const RhombusScene& scene, const RhombusBody& body, BodyId id) {
  const Pressed& pressed = pressed_body(input.measures.pressed, id);
  const rhombus::ChainParams& chain = scene.params.chain;
  const rhombus::Tissue* tissue = rhombus::find_tissue(scene.tissue);
  return {{"name", body.name},
          {"model", model_name(BodyKind::kRhombus)},
          {"source", std::visit(SourceText{}, scene.source)},
          {"tissue", scene.tissue},
          {"tissue_source", tissue ? tissue->source : ""},
          {"vertices", body.model.surface.vertices.size()},
          {"triangles", body.model.surface.triangles.size()},
          {"volume_ml", rounded(body.volume * 1e6)},
          {"normal_N_per_m", rounded(chain.normal)},
          {"tangential_N_per_m", rounded(chain.tangential)},
          {"decay", rounded(chain.decay)},
          {"angle_deg", rounded(chain.angle * 180 / std::numbers::pi)},
          {"side_mm", rounded(chain.side * kMm)},
          {"bulge", rounded(scene.params.bulge)},
          {"build_s", rounded(body.build_seconds)},
          {"surface_p50_ms", rounded(percentile(pressed.surface_seconds, 0.5) * kMs)},
          {"pressed_volume_ml", rounded(body.pressed_volume * 1e6)},
          {"force_max_N", rounded(pressed.force)},
          {"force_max_at_s", rounded(pressed.time)},
          {"jump_per_10_um_N", rounded(body.jump)},
          {"jump_at_s", rounded(body.jump_at)}};
}

}  // namespace turgor

#include "turgor/sim/report/report_skin.hpp"

#include <algorithm>

#include "turgor/geometry/surface_stretch.hpp"
#include "turgor/sim/report/section.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

using namespace units;

const Quantity<SkinStretch> kSkinStretch[] = {
    {"name", kNone, "", [](const SkinStretch& s) -> Json { return s.body; }, kInReport},
    {"largest_stretch", kNone, "largest mean stretch of a disc of skin of 5 mm radius",
     [](const SkinStretch& s) -> Json { return s.largest; }, kEverywhere,
     "largest stretch of the skin, mean of a disc of 5 mm radius"},
    {"x", kMillimeters, "x there", [](const SkinStretch& s) -> Json { return s.now.x; }},
    {"y", kMillimeters, "y there", [](const SkinStretch& s) -> Json { return s.now.y; }},
    {"z", kMillimeters, "z there", [](const SkinStretch& s) -> Json { return s.now.z; }},
    {"in_ct.x", kMillimeters, "x in the CT", [](const SkinStretch& s) -> Json { return s.rest.x; }},
    {"in_ct.y", kMillimeters, "y in the CT", [](const SkinStretch& s) -> Json { return s.rest.y; }},
    {"in_ct.z", kMillimeters, "z in the CT", [](const SkinStretch& s) -> Json { return s.rest.z; }},
};

/// True if a body has an excision or a suture.
bool has_closed_wound(const World& world, int body) {
  return std::any_of(world.cuts.begin(), world.cuts.end(),
                     [body](const Cut& cut) { return cut.body == body && cut.blade.excision; }) ||
         std::any_of(world.sutures.begin(), world.sutures.end(),
                     [body](const Suture& suture) { return suture.scene.body == body; });
}

/// Triangles without caps and walls of wounds; empty for bodies without skin.
std::span<const Int3> triangles_of_skin(const BodySnapshot& body) {
  if (body.look != Look::kSkin || body.rest.size() != body.x.size()) return {};
  return outer_triangles(body);
}

}  // namespace

std::vector<float> skin_stretches(const BodySnapshot& body) {
  const std::span<const Int3> skin = triangles_of_skin(body);
  if (skin.empty()) return {};
  return principal_stretches(body.rest, body.x, skin);
}

std::optional<SkinStretch> largest_skin_stretch(const BodySnapshot& body) {
  constexpr double kDisc = 0.005;  // radius [m]
  const std::span<const Int3> skin = triangles_of_skin(body);
  if (skin.empty()) return std::nullopt;
  const DiscStretch most = largest_stretch_of_discs(body.rest, body.x, skin, kDisc);
  return SkinStretch{body.name, most.mean, Vec3d(body.x[most.vertex]), Vec3d(body.rest[most.vertex])};
}

std::optional<SkinStretch> largest_skin_stretch(const Exec& exec, const World& world, int lattice_body) {
  const LatticeBody& body = world.lattice_bodies[std::size_t(lattice_body)];
  BodySnapshot snapshot;
  show_name({BodyKind::kLattice, lattice_body}, body, snapshot);
  show(exec, body, snapshot);
  return largest_skin_stretch(snapshot);
}

Json skin_report(const Exec& exec, const World& world) {
  Json rows = Json::array();
  for (int b = 0; b < int(world.lattice_bodies.size()); b++) {
    if (!has_closed_wound(world, b)) continue;
    if (const auto stretch = largest_skin_stretch(exec, world, b))
      rows.push_back(values_of(kSkinStretch, *stretch));
  }
  return rows;
}

Section skin_section() {
  return {"Skin", "body", [](const Json& report) { return items_of(report, "skin"); },
          captions_of(kSkinStretch)};
}

}  // namespace turgor

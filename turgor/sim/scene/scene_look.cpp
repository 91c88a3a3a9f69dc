#include "turgor/sim/scene/scene_look.hpp"

#include "turgor/sim/scene/scene_body.hpp"

namespace turgor {

void read_wet(SceneTable& body, const std::string& name, LookScene& look) {
  bool wet = false;
  body.read("wet", wet,
            {"pictures show a film of water on the body, and on the walls of its wounds",
             "true for sfem and rhombus"});
  if (body.has("wet")) look.wet[name] = wet;
}

void read_cutaway(SceneTable& output, Scene& scene) {
  // keys
  SceneTable table = output.table("cutaway");
  CutawayScene cutaway;
  if (output.has("cutaway")) table.require({"body"}, "the body that is cut away");
  cutaway.body = read_body(table, "body", scene, {BodyKind::kSfem, BodyKind::kRhombus, BodyKind::kLattice});
  Vec3d at;
  table.read("at", at, any_number("m"), {"point of the plane", "none"});
  table.read("at_fraction", cutaway.at, within(0, 1, "1"), "instead: in fractions of the body's box at rest");
  table.read("normal", cutaway.normal, any_number("1"),
             "direction from the plane to the side that is not drawn; any length");
  Vec3d wedge;
  table.read("wedge", wedge, any_number("1"),
             {"direction of a second plane through the same point: only what lies on the removed side of "
              "both is not drawn",
              "none"});
  table.read_choice<bool>("inclusions", cutaway.cuts_inclusions, {{"whole", false}, {"cut", true}},
                          "`\"whole\"`: inclusions stand out of the section; `\"cut\"`: they are cut, too");

  // meaning
  if (table.has("at")) cutaway.at = at, cutaway.by_fraction = false;
  if (table.has("wedge")) cutaway.wedge = wedge;
  if (table.has("at") && table.has("at_fraction"))
    table.fail("at", "expected either at or at_fraction, found both");
  if (!(norm(cutaway.normal) > 0))
    table.fail("normal", "expected a direction, found a vector without length");
  if (cutaway.wedge && !(norm(cross(normalized(*cutaway.wedge), normalized(cutaway.normal))) > 1e-6))
    table.fail("wedge", "expected a direction that is not parallel to normal");
  table.finish();
  if (output.has("cutaway")) scene.look.cutaway = cutaway;
  scene.look.window = scene.output.window;
}

CutawayPlanes cutaway_planes(const CutawayScene& cutaway, const Box& box) {
  const Vec3d at = cutaway.by_fraction ? box.low + hadamard(box.high - box.low, cutaway.at) : cutaway.at;
  CutawayPlanes planes{at, {normalized(cutaway.normal)}};
  if (cutaway.wedge) planes.normals.push_back(normalized(*cutaway.wedge));
  return planes;
}

}  // namespace turgor

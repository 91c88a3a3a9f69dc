#include "turgor/sim/scene/scene_solid_source.hpp"

#include "turgor/sim/scene/scene_ct.hpp"
#include "turgor/sim/scene/scene_up.hpp"

namespace turgor {

namespace {

const Allowed kResolution = within(1e-4, 1, "m");
const Allowed kMetersPerUnit = inside(0, 1e6, "m");

void read_resolution(SceneTable& table, std::optional<double>& resolution) {
  double given = kUsualEdge;
  table.read("resolution", given, kResolution,
             {"with `surface` and `labels`: about the edge length of the tetrahedra",
              "0.02, but at most a fifth of the cube root of the body's volume"});
  if (table.has("resolution")) resolution = given;
}

LabeledOrgan read_labeled_organ(SceneTable& table, SceneLabels& names) {
  // segmentation file or phantom
  LabeledOrgan organ;
  const toml::node* labels = table.find("labels");
  if (labels->is_table())
    organ.phantom = read_phantom(table.table("labels"));
  else
    table.read_path(
        "labels", organ.file,
        {"a segmentation, one label of which is meshed with tetrahedra: a file, or `{ phantom = \"torso\" }`",
         "none"});
  // label to mesh
  table.require({"label"}, "the label of the body: a number, or a name such as \"liver\"");
  read_label(
      table, "label", names, organ.label,
      {"a number, or a name such as `\"liver\"`: one of the file of `labels`, or of TotalSegmentator if the "
       "file has no names; the nodule of the phantom is `\"nodule\"`",
       "required with `labels`"});
  // mesh
  read_resolution(table, organ.resolution);
  table.read_choice<bool>(
      "cavities", organ.are_cavities_filled, {{"fill", true}, {"keep", false}},
      {"with `labels`: where the body encloses labels of no other body of the scene, it has its own tissue "
       "(`\"fill\"`) or is hollow (`\"keep\"`)",
       "`\"fill\"`"});
  return organ;
}

HexBlock read_hex_block(SceneTable table) {
  HexBlock block;
  table.require({"size"}, "the block's size, [x, y, z] [m]");
  table.require({"count"}, "hexahedra along x, y and z");
  table.read("size", block.size, inside(0, 100, "m"),
             "size of a block of hexahedra, for comparison with theory");
  table.read("count", block.count, within(1, 200), "hexahedra along x, y and z");
  table.read("corner", block.corner, within(-100, 100, "m"), "position of its low corner");
  table.finish();
  return block;
}

}  // namespace

SolidSource read_solid_source(SceneTable& body, SceneLabels& labels) {
  // exactly one shape is allowed
  const std::vector<std::string> kinds = {"mesh", "surface", "labels", "block"};
  body.require(kinds, "the shape of the body");
  std::string given;
  for (const std::string& kind : kinds) {
    if (!body.has(kind)) continue;
    if (!given.empty()) {
      body.fail(kind, fmt::format("a body has one shape: either {} or {}", given, kind));
      body.find("label");  // of the shape that is not read
    }
    given = given.empty() ? kind : given;
  }
  // labels, block or surface
  if (given == "labels") return read_labeled_organ(body, labels);
  if (given == "block") return read_hex_block(body.table("block"));
  if (given == "surface") {
    ClosedSurface surface;
    body.read_path("surface", surface.file,
                   {"or a closed surface, filled with tetrahedra: OBJ, STL, PLY, VTP, VTK", "none"});
    body.read("scale", surface.scale, kMetersPerUnit,
              "with `mesh` and `surface`: meters per unit of the file; 0.001 for a file in mm");
    surface.is_scale_given = body.has("scale");
    read_up(body, "up", surface.up);
    read_resolution(body, surface.resolution);
    return surface;
  }
  // volume mesh file
  SolidFile solid;
  body.read_path("mesh", solid.file,
                 {"a file of tetrahedra or hexahedra: Gmsh, VTK, VTU, TetGen, Medit",
                  "one of `mesh`, `surface`, `labels`, `block`"});
  body.read("scale", solid.scale, kMetersPerUnit,
            "with `mesh` and `surface`: meters per unit of the file; 0.001 for a file in mm");
  solid.is_scale_given = body.has("scale");
  read_up(body, "up", solid.up);
  return solid;
}

}  // namespace turgor

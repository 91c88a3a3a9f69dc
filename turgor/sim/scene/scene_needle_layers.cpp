#include "turgor/sim/scene/scene_needle_layers.hpp"

namespace turgor {

namespace {

const Allowed kHounsfield = within(-1024, 3071, "HU");

/// One layer, and the check that its tissue is given in one way.
NeedleLayerScene read_needle_layer(SceneTable& inner, const std::string& name, bool has_labels,
                                   SceneLabels& labels) {
  NeedleLayerScene layer{.name = name};
  inner.require({"label", "hu", "depth"}, "which tissue it is");
  read_label(inner, "label", labels, layer.label,
             {"tissue with this label, a number or a name, has a resistance of its own to needles "
              "(docs/needle.md)",
              "none"});
  read_hu_range(inner, layer.hu);
  inner.read("depth", layer.depth, inside(0, 1, "m"),
             {"instead: tissue down to this depth below the skin; comes before labels and HU, the thinnest "
              "layer first",
              "none"});
  // exactly one kind
  if (inner.has("label") + inner.has("hu") + inner.has("depth") > 1)
    inner.fail(inner.has("hu") ? "hu" : "depth",
               "a layer has one of label, hu and depth: the others would be ignored");
  if (inner.has("label") && !has_labels)
    inner.fail("label", "a layer by label needs a segmentation: add labels = \"seg.nii.gz\" to the body");
  // resistance
  inner.read("toughness", layer.toughness, within(-1, 1e5, "J/m²"),
             {"against needles; -1 is the default", "that of the needle's `shape.toughness`"});
  inner.read("shaft_friction", layer.friction, within(-1, 1e4, "N/m"),
             {"along needles, per length; -1 is the default", "that of the needle's `shape.shaft_friction`"});
  inner.finish();
  return layer;
}

}  // namespace

void read_hu_range(SceneTable& table, std::optional<std::array<double, 2>>& hu) {
  table.describe("hu", "HU", "none", "instead: `[from, to]`, tissue with these values in the CT",
                 kHounsfield);
  const toml::node* node = table.find("hu");
  if (!node) return;
  const std::vector<double> range = table.numbers("hu", *node, kHounsfield);
  if (range.size() == 2 && range[0] < range[1])
    hu = {range[0], range[1]};
  else if (!range.empty())
    table.fail_value("hu", *node, "[from, to] with from < to [HU]");
}

std::vector<NeedleLayerScene> read_needle_layers(SceneTable& body, bool has_labels, SceneLabels& labels) {
  std::vector<NeedleLayerScene> layers;
  SceneTable table = body.table("inside");
  for (const std::string& name : table.names()) {
    SceneTable inner = table.named(name);
    NeedleLayerScene layer = read_needle_layer(inner, name, has_labels, labels);
    // ranges of HU do not overlap
    for (const NeedleLayerScene& other : layers)
      if (overlap(layer.hu, other.hu))
        inner.fail("hu",
                   fmt::format("the range overlaps that of {}: expected each HU in one layer", other.name));
    layers.push_back(std::move(layer));
  }
  return layers;
}

}  // namespace turgor

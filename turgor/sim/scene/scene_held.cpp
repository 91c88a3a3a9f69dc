#include "turgor/sim/scene/scene_held.hpp"

#include <string_view>

#include <fmt/format.h>

namespace turgor {

namespace {

const std::vector<std::pair<std::string, Side>>& side_names() {
  static const std::vector<std::pair<std::string, Side>> kNames = {
      {"right", Side::kRight}, {"left", Side::kLeft}, {"front", Side::kFront}, {"back", Side::kBack},
      {"feet", Side::kFeet},   {"head", Side::kHead}, {"bottom", Side::kFeet}, {"top", Side::kHead}};
  return kNames;
}

/// `instead`: another value that the key may have, as "none"; empty without.
void read_sides(SceneTable& table, const std::string& key, const std::string& instead,
                std::vector<Side>& sides) {
  const toml::node* node = table.find(key);
  if (!node) return;
  sides.clear();
  const auto add = [&](const toml::node& name, const std::string& other) {
    std::vector<std::string> names;
    for (const auto& [known, side] : side_names()) {
      if (name.value_or(std::string()) == known) return sides.push_back(side);
      names.push_back(known);
    }
    std::string expected =
        "\"right\", \"left\", \"front\", \"back\", \"feet\" (or \"bottom\") or \"head\" (or \"top\")";
    if (!other.empty()) names.push_back(other), expected += fmt::format("; or \"{}\"", other);
    table.fail_name(key, name, expected, names);
  };
  if (!node->is_array()) return add(*node, instead);
  for (const toml::node& name : *node->as_array()) add(name, "");
}

}  // namespace

HeldBy read_held(SceneTable& body) {
  HeldBy held;
  // short form: one or several sides
  const toml::node* node = body.find("fixed");
  body.describe(
      "fixed", "", "`\"back\"`",
      "fixed vertices: those within a tenth of the body's box from one or several sides (`\"right\"`, "
      "`\"left\"`, `\"front\"`, `\"back\"`, `\"feet\"` or `\"bottom\"`, `\"head\"` or `\"top\"`); a table of "
      "the keys "
      "below; or, for sfem, `\"none\"`");
  if (!node || !node->is_table()) return read_sides(body, "fixed", "none", held.sides), held;
  // table form: sides and depth
  SceneTable table = body.table("fixed");
  table.require({"sides", "box", "box_fraction"}, "which vertices are fixed");
  read_sides(table, "sides", "", held.sides);
  table.read("depth", held.depth, within(0, 1),
             "depth from a side, relative to the body's box; 0 fixes the outermost vertices only");
  // documented keys
  table.describe("sides", "", "one of `sides`, `box`, `box_fraction`", "one or several, as above");
  table.describe("box", "m", "none", "`[[x, y, z], [x, y, z]]`: vertices in this box");
  table.describe("box_fraction", "", "none", "the same box in fractions of the body's box");
  // parse box corners, in meters or fractions
  for (const char* key : {"box", "box_fraction"}) {
    const toml::node* corners = table.find(key);
    if (!corners) continue;
    std::vector<double> v;
    if (corners->is_array())
      for (const toml::node& corner : *corners->as_array())
        for (const double x : table.numbers(key, corner, any_number("m"))) v.push_back(x);
    if (v.size() != 6) {
      table.fail_value(key, *corners, "two corners, [[x, y, z], [x, y, z]]");
      continue;
    }
    held.box = {{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}}};
    held.by_fraction = std::string_view(key) == "box_fraction";
  }
  table.finish();
  return held;
}

}  // namespace turgor

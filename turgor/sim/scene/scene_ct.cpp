#include "turgor/sim/scene/scene_ct.hpp"

namespace turgor {

PhantomParams read_phantom(SceneTable table) {
  PhantomKind kind = PhantomKind::kTorso;
  table.require({"phantom"}, "which anatomy: \"torso\", \"head\" or \"leg\"");
  table.read_choice<PhantomKind>(
      "phantom", kind,
      {{"torso", PhantomKind::kTorso}, {"head", PhantomKind::kHead}, {"leg", PhantomKind::kLeg}});
  PhantomParams phantom = default_phantom(kind);
  table.read("size", phantom.size, within(8, 2048, "voxels"));
  Vec3d spacing_mm = phantom.spacing * 1e3;
  table.read("spacing_mm", spacing_mm, within(0.05, 50, "mm"));
  phantom.spacing = spacing_mm / 1e3;
  int seed = int(phantom.seed);
  table.read("seed", seed, within(0, 2e9));
  phantom.seed = std::uint64_t(seed);
  table.finish();
  return phantom;
}

namespace {

/// A number of the list that several series give, or a SeriesInstanceUID.
void read_series(SceneTable& table, std::string& series) {
  const toml::node* node = table.find("series");
  if (!node || !node->is_integer()) return table.read("series", series);
  int number = 0;
  table.read("series", number, within(1, 1e6));
  series = std::to_string(number);
}

}  // namespace

CtSource read_ct_source(SceneTable& table) {
  CtSource source;
  table.require({"ct"}, "a CT file or DICOM folder, or { phantom = \"torso\" }");
  read_series(table, source.series);
  const toml::node* node = table.find("ct");
  if (!node) return source;
  if (!node->is_table()) {
    table.read_path("ct", source.file);
    return source;
  }
  source.phantom = read_phantom(table.table("ct"));
  return source;
}

}  // namespace turgor

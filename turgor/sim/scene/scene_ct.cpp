#include "turgor/sim/scene/scene_ct.hpp"

namespace turgor {

PhantomParams read_phantom(SceneTable table) {
  // anatomy, which sets the defaults
  PhantomKind kind = PhantomKind::kTorso;
  table.begin_group("phantom");
  table.require({"phantom"}, "which anatomy: \"torso\", \"head\" or \"leg\"");
  table.read_choice<PhantomKind>(
      "phantom", kind,
      {{"torso", PhantomKind::kTorso}, {"head", PhantomKind::kHead}, {"leg", PhantomKind::kLeg}},
      {"which anatomy: `\"torso\"`, `\"head\"` or `\"leg\"`", "required"});
  PhantomParams phantom = default_phantom(kind);
  // keys with limits; the scene gives millimeters
  table.read("size", phantom.size, within(8, 2048, "voxels"),
             {"voxels along x, y, z", "512×512×300 (torso), ×544 (head), ×1152 (leg)"});
  Vec3d spacing_mm = phantom.spacing * 1e3;
  table.read("spacing_mm", spacing_mm, within(0.05, 50, "mm"),
             {"distance between voxels", "the phantom's own"});
  phantom.spacing = spacing_mm / 1e3;
  int seed = int(phantom.seed);
  table.read("seed", seed, within(0, 2e9), "random seed of the noise and of anatomical variation");
  phantom.seed = std::uint64_t(seed);
  table.finish();
  return phantom;
}

namespace {

/// DICOM series: an index into the list of `turgor info`, or a SeriesInstanceUID.
void read_series(SceneTable& table, std::string& series) {
  const toml::node* node = table.find("series");
  if (!node || !node->is_integer())
    return table.read("series", series,
                      {"DICOM: which series, when a folder holds several: its number in the list that "
                       "`turgor info` gives, or its SeriesInstanceUID",
                       "the only one"});
  int number = 0;
  table.read("series", number, within(1, 1e6),
             {"DICOM: which series, when a folder holds several: its number in the list that `turgor info` "
              "gives, or its SeriesInstanceUID",
              "the only one"});
  series = std::to_string(number);
}

}  // namespace

CtSource read_ct_source(SceneTable& table) {
  // require and describe the source
  CtSource source;
  table.require({"ct"}, "a CT file or DICOM folder, or { phantom = \"torso\" }");
  read_series(table, source.series);
  const toml::node* node = table.find("ct");
  table.describe(
      "ct", "", "required",
      "a DICOM folder, `.nii`, `.nii.gz`, `.nrrd`, `.mha`; or a phantom, as `{ phantom = \"torso\" }`");
  if (!node) return source;
  // a file or DICOM folder
  if (!node->is_table()) {
    table.read_path(
        "ct", source.file,
        {"a DICOM folder, `.nii`, `.nii.gz`, `.nrrd`, `.mha`; or a phantom, as `{ phantom = \"torso\" }`",
         "required"});
    return source;
  }
  // a phantom
  source.phantom = read_phantom(table.table("ct"));
  return source;
}

}  // namespace turgor

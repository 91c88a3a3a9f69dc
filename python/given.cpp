#include "given.hpp"

#include <fmt/format.h>

#include "turgor/geometry/reorient.hpp"
#include "turgor/io/volume/volume_file.hpp"

namespace turgor {

namespace {

Vec3d vec_of(const std::vector<double>& v, std::size_t first = 0, std::size_t stride = 1) {
  return {v.at(first), v.at(first + stride), v.at(first + 2 * stride)};
}

template <class T>
Volume<T> volume_of(const std::string& name, const VolumeOfPython<T>& given) {
  const auto& [samples, spacing, origin, axes] = given;
  Volume<T> volume;
  volume.grid.size = {int(samples.shape(2)), int(samples.shape(1)), int(samples.shape(0))};
  volume.grid.spacing = vec_of(spacing), volume.grid.origin = vec_of(origin);
  volume.grid.axes = {{vec_of(axes, 0, 3), vec_of(axes, 1, 3), vec_of(axes, 2, 3)}};
  required(io::check_grid("the volume of " + name, volume.grid));
  volume.samples.assign(samples.data(), samples.data() + samples.size());
  return volume;
}

template <class T, class Field>
Status set_volumes_of(const std::map<std::string, T>& volumes, Scene& scene, const Field& field) {
  for (const auto& [name, volume] : volumes) {
    bool found = false;
    for (LatticeScene& body : scene.lattice_bodies)
      if (body.name == name) field(body) = volume, found = true;
    if (!found)
      return Error{
          fmt::format("{}: expected a body with model = \"lattice\" for the volume, found none", name)};
  }
  return Done{};
}

/// Replaces the folder of meshes in memory.
void hide_folder(const std::string& folder, std::string& text) {
  constexpr std::string_view kWords = "given in memory";
  if (folder.empty()) return;
  for (std::size_t at = text.find(folder); at != text.npos; at = text.find(folder, at + kWords.size()))
    text.replace(at, folder.size(), kWords);
}

}  // namespace

GivenVolumes given_volumes(const VolumesOfPython<std::int16_t>& volumes,
                           const VolumesOfPython<std::uint16_t>& labels) {
  GivenVolumes given;
  for (const auto& [name, fields] : volumes) {
    CtVolume volume = volume_of(name, fields);
    if (!(determinant(volume.grid.axes) > 0)) given.left_handed[name] = volume.grid;
    given.volumes[name] = std::make_shared<const CtVolume>(right_handed(std::move(volume)));
  }
  for (const auto& [name, fields] : labels)
    given.labels[name] = std::make_shared<const LabelVolume>(right_handed(volume_of(name, fields)));
  return given;
}

Status set_volumes(const GivenVolumes& given, Scene& scene) {
  Status status = set_volumes_of(
      given.volumes, scene, [](LatticeScene & body) -> auto& { return body.ct.given; });
  if (!status) return status;
  return set_volumes_of(
      given.labels, scene, [](LatticeScene & body) -> auto& { return body.given_labels; });
}

Scene given_scene(const std::filesystem::path& file, const std::optional<std::string>& text,
                  const std::vector<std::string>& overrides, const std::string& folder) {
  Scene scene = required(text ? parse_scene(*text, file, overrides) : read_scene(file, overrides));
  hide_folder(folder, scene.text);
  for (std::string& one : scene.overrides) hide_folder(folder, one);
  for (SceneParameter& parameter : scene.parameters) hide_folder(folder, parameter.value);
  return scene;
}

}  // namespace turgor

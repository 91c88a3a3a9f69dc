// Scenes and volumes from Python values.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "arrays.hpp"
#include "turgor/sim/scene/scene.hpp"

namespace turgor {

template <class T>
using Samples = nb::ndarray<const T, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
/// Samples [k, j, i], spacing [m], origin [m], and directions of i, j, k as columns of a row-major matrix.
template <class T>
using VolumeOfPython = std::tuple<Samples<T>, std::vector<double>, std::vector<double>, std::vector<double>>;
template <class T>
using VolumesOfPython = std::map<std::string, VolumeOfPython<T>>;

/// Volumes in memory, by body name. They are right-handed.
struct GivenVolumes {
  std::map<std::string, std::shared_ptr<const CtVolume>> volumes;
  std::map<std::string, std::shared_ptr<const LabelVolume>> labels;
  std::map<std::string, Grid> left_handed;  // grids of volumes whose samples were mirrored along i
};
GivenVolumes given_volumes(const VolumesOfPython<std::int16_t>& volumes,
                           const VolumesOfPython<std::uint16_t>& labels);
/// Set the volumes of a scene. Error: unknown lattice body.
Status set_volumes(const GivenVolumes& given, Scene& scene);

/// Scene of a file or a text. Fixed words replace `folder`, the temporary folder of meshes in memory, in the
/// text, the overrides and the parameters that the scene keeps. Equal scenes then have equal texts.
Scene given_scene(const std::filesystem::path& file, const std::optional<std::string>& text,
                  const std::vector<std::string>& overrides, const std::string& folder);

}  // namespace turgor

// [body.NAME] with model = "rhombus", a surface of rhombus chains, as plain structs. docs/scene.md lists
// keys, units and defaults. Nothing is loaded here.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "turgor/geometry/up_axis.hpp"
#include "turgor/models/rhombus/rhombus.hpp"
#include "turgor/sim/scene/ct_source.hpp"
#include "turgor/sim/scene/texture_scene.hpp"
#include "turgor/sim/scene/tissue_row.hpp"

namespace turgor {

/// A closed surface from a file.
struct SurfaceFile {
  std::filesystem::path file;
  double scale = 1;  // meters per unit of the file
  bool is_scale_given = false;
  UpAxis up = UpAxis::kZ;  // the file's axis that points to the head
};
/// Phantom liver with edges divided by `detail`.
struct PhantomLiverSurface {
  double detail = 1;
};
/// The surface of a body with model = "sfem" of the same scene.
struct SurfaceOfBody {
  int body = 0;  // index into Scene::sfem_bodies
};
using RhombusSource = std::variant<SurfaceFile, PhantomLiverSurface, SurfaceOfBody>;

/// Stiffness factors by label.
struct LabelStiffness {
  std::filesystem::path labels;
  std::optional<PhantomParams> phantom;  // instead of a file
  std::map<int, double> factors;         // by label [1]
  std::string label_note;                // set if label names are not from the file
};
/// Stiffness factors by CT value: linear between the given values, constant beyond.
struct CtStiffness {
  CtSource ct;
  std::map<double, double> factors;  // by Hounsfield units [1]
};
/// Stiffness of the sfem body that owns the surface.
struct ElasticStiffness {
  int body = 0;  // index into Scene::sfem_bodies
};
/// Labels and CT values are sampled down to `depth` below the surface.
struct StiffnessScene {
  std::variant<LabelStiffness, CtStiffness, ElasticStiffness> source;
  double depth = 0.02;  // [m]
};

struct RhombusScene {
  std::string name;
  std::string source_location;  // "scene.toml:7:1: body.liver", for errors found later
  RhombusSource source;
  std::string tissue;  // name of a preset, source of the chain
  rhombus::Params params;
  std::vector<TissueRow> tissues;  // laws and values with their source, for the report
  double stiffness_scale = 1;      // of all stiffnesses [1]
  TextureScene texture;
  std::optional<StiffnessScene> stiffness;
};

}  // namespace turgor

// [body.NAME] with model = "rhombus": a body's surface that gives like chains of rhombi, as the plain
// struct that a scene becomes. Keys, units and defaults are listed in docs/scene.md; nothing is loaded here.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <variant>

#include "turgor/geometry/up_axis.hpp"
#include "turgor/models/rhombus/rhombus.hpp"
#include "turgor/sim/scene/ct_source.hpp"

namespace turgor {

/// A closed surface from a file.
struct SurfaceFile {
  std::filesystem::path file;
  double scale = 1;        // metres a unit of the file
  UpAxis up = UpAxis::kZ;  // the file's axis that points to the head
};
/// The phantom liver, finer by `detail`.
struct PhantomLiverSurface {
  double detail = 1;
};
/// The surface of a body with model = "sfem" of the same scene.
struct SurfaceOfBody {
  int body = 0;  // index into Scene::sfem_bodies
};
using RhombusSource = std::variant<SurfaceFile, PhantomLiverSurface, SurfaceOfBody>;

/// How many times as stiff what a label marks is.
struct LabelStiffness {
  std::filesystem::path labels;
  std::optional<PhantomParams> phantom;  // instead of a file
  std::map<int, double> factors;         // by label [1]
  std::string label_note;                // when names of labels were not the file's own
};
/// How many times as stiff tissue of a grey value is: linear between the given values, constant beyond.
struct CtStiffness {
  CtSource ct;
  std::map<double, double> factors;  // by Hounsfield units [1]
};
/// As stiff as the body of finite elements whose surface it is.
struct ElasticStiffness {
  int body = 0;  // index into Scene::sfem_bodies
};
/// Labels and grey values are felt from `depth` below the surface.
struct StiffnessScene {
  std::variant<LabelStiffness, CtStiffness, ElasticStiffness> source;
  double depth = 0.02;  // [m]
};

struct RhombusScene {
  std::string name;
  std::string place;  // "scene.toml:7:1: body.liver", for errors found later
  RhombusSource source;
  std::string tissue;  // of rhombus/tissues.hpp, where the chain comes from
  rhombus::Params params;
  std::optional<StiffnessScene> stiffness;
};

}  // namespace turgor

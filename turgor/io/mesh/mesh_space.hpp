// Places and fields of a mesh in the unit and along the axes of a file. Internal to io/.
#pragma once

#include <fmt/format.h>

#include "turgor/io/mesh/mesh_files.hpp"

namespace turgor::io {

inline const char* frame_name(MeshSpace space) { return space.is_ras ? "RAS" : "LPS"; }
inline std::string space_text(MeshSpace space) {
  return fmt::format("{}, patient frame {} ({}, z to the head)", space.is_mm ? "millimetres" : "metres",
                     frame_name(space),
                     space.is_ras ? "x to the right, y to the front" : "x to the left, y to the back");
}

/// Along the axes of the file; zero keeps no sign.
inline Vec3 turned(Vec3 v, MeshSpace space) { return space.is_ras ? Vec3{-v.x, -v.y, v.z} + Vec3{} : v; }
inline std::vector<Vec3> turned(std::vector<Vec3> vectors, MeshSpace space) {
  for (Vec3& v : vectors) v = turned(v, space);
  return vectors;
}
inline std::vector<Vec3> placed(std::vector<Vec3> places, MeshSpace space) {
  for (Vec3& x : places) x = turned(space.is_mm ? x * 1000.0f : x, space);
  return places;
}

/// A length in the file's unit, a vector along its axes; all else as it is.
inline std::vector<float> placed_values(const VertexField& field, MeshSpace space) {
  std::vector<float> values(field.values.begin(), field.values.end());
  if (!field.is_length && !field.is_direction) return values;
  for (std::size_t i = 0; i < values.size(); i++) {
    if (space.is_mm && field.is_length) values[i] *= 1000;
    if (space.is_ras && field.components == 3 && i % 3 < 2) values[i] = 0 - values[i];
  }
  return values;
}
/// With its unit.
inline std::string placed_name(const VertexField& field, MeshSpace space) {
  return field.is_length ? fmt::format("{} [{}]", field.name, unit_name(space)) : field.name;
}

}  // namespace turgor::io

// Positions and fields of a mesh in the unit and along the axes of a file. Internal to io/.
#pragma once

#include <fmt/format.h>

#include "turgor/io/mesh/mesh_files.hpp"

namespace turgor::io {

inline const char* frame_name(MeshSpace space) { return space.is_ras ? "RAS" : "LPS"; }
inline std::string space_text(MeshSpace space) {
  return fmt::format("{}, patient frame {} ({}, z to the head)", space.is_mm ? "millimeters" : "meters",
                     frame_name(space),
                     space.is_ras ? "x to the right, y to the front" : "x to the left, y to the back");
}

/// Vector along the axes of the file; zeros are positive.
inline Vec3 to_file_axes(Vec3 v, MeshSpace space) {
  return space.is_ras ? Vec3{-v.x, -v.y, v.z} + Vec3{} : v;
}
inline std::vector<Vec3> to_file_axes(std::vector<Vec3> vectors, MeshSpace space) {
  for (Vec3& v : vectors) v = to_file_axes(v, space);
  return vectors;
}
inline std::vector<Vec3> in_space(std::vector<Vec3> positions, MeshSpace space) {
  for (Vec3& x : positions) x = to_file_axes(space.is_mm ? x * 1000.0f : x, space);
  return positions;
}

/// Values in the file's unit (lengths) and along its axes (vectors); all others unchanged.
inline std::vector<float> values_in_space(const VertexField& field, MeshSpace space) {
  std::vector<float> values(field.values.begin(), field.values.end());
  if (!field.is_length && !field.is_direction) return values;
  for (std::size_t i = 0; i < values.size(); i++) {
    if (space.is_mm && field.is_length) values[i] *= 1000;
    if (space.is_ras && field.components == 3 && i % 3 < 2) values[i] = 0 - values[i];
  }
  return values;
}
/// Name of the field, with the unit of a length.
inline std::string name_in_space(const VertexField& field, MeshSpace space) {
  return field.is_length ? fmt::format("{} [{}]", field.name, unit_name(space)) : field.name;
}

}  // namespace turgor::io

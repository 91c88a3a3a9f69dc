// Meshes in `turgor info`: solids (Gmsh, VTK, VTU, TetGen, Medit) and surfaces (OBJ, STL, PLY, VTP, VTK).
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "turgor/core/exec.hpp"
#include "turgor/core/vec.hpp"

namespace turgor {

/// True if the file begins as one of the mesh formats.
bool is_mesh_file(const std::string& path);
/// Kind, counts, regions, box, volume, edges, angles and repairs. Coordinates times `scale` are meters.
/// Throws Failure.
nlohmann::ordered_json describe_mesh(const Exec& exec, const std::string& path, double scale);
void print_mesh(const nlohmann::ordered_json& json);

inline nlohmann::ordered_json triple(Vec3d v) { return nlohmann::ordered_json::array({v.x, v.y, v.z}); }

}  // namespace turgor

#include "app/info_mesh.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "app/commands.hpp"
#include "app/print.hpp"
#include "turgor/geometry/mesh_quality.hpp"
#include "turgor/geometry/surface_check.hpp"
#include "turgor/io/mesh/solid_files.hpp"
#include "turgor/io/mesh/surface_files.hpp"

namespace turgor {

namespace {

using Json = nlohmann::ordered_json;

template <class T>
void add_box(const std::vector<Vec<T>>& vertices, Json& json) {
  Vec<T> low = vertices.front(), high = low;
  for (const Vec<T> x : vertices) {
    low = min(low, x);
    high = max(high, x);
  }
  json.update({{"box_from_m", triple(Vec3d(low))}, {"box_to_m", triple(Vec3d(high))}});
}

/// Adds the shortest and the longest of these edges.
template <class Vertices, class Corners>
void add_edges(const Vertices& vertices, const std::vector<Corners>& edges, Json& json) {
  double shortest = std::numeric_limits<double>::infinity(), longest = 0;
  for (const auto& [a, b] : edges) {
    const double length = norm(Vec3d(vertices[std::size_t(a)]) - Vec3d(vertices[std::size_t(b)]));
    shortest = std::min(shortest, length);
    longest = std::max(longest, length);
  }
  json.update({{"shortest_edge_m", shortest}, {"longest_edge_m", longest}});
}

std::vector<std::pair<int, int>> hexahedron_edges(const SolidMesh& mesh) {
  constexpr std::array<std::pair<std::size_t, std::size_t>, 12> kEdges{
      {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}}};
  std::vector<std::pair<int, int>> edges;
  for (std::size_t e = 0; e < element_count(mesh); e++)
    for (const auto& [a, b] : kEdges) edges.emplace_back(element(mesh, e)[a], element(mesh, e)[b]);
  return edges;
}

Json describe_regions(const SolidMesh& mesh) {
  std::map<int, std::pair<std::size_t, double>> found;  // elements, volume
  for (std::size_t e = 0; e < element_count(mesh); e++) {
    auto& [count, size] = found[region(mesh, e)];
    count++;
    size += volume(mesh, e);
  }
  Json list = Json::array();
  for (const auto& [number, measures] : found)
    list.push_back({{"region", number}, {"elements", measures.first}, {"volume_m3", measures.second}});
  return list;
}

Json describe_solid(const std::string& path, double scale) {
  const ReadSolid read = required(read_solid(path, scale));
  const SolidMesh& mesh = read.mesh;
  const std::vector<int> components = connected_components(mesh);
  Json json{{"path", path},
            {"format", read.format},
            {"kind", mesh.corners == 4 ? "tetrahedra" : "hexahedra"},
            {"vertices", mesh.vertices.size()},
            {"elements", element_count(mesh)},
            {"components", 1 + *std::max_element(components.begin(), components.end())},
            {"surface_triangles", surface(mesh).triangles.size()},
            {"inverted_repaired", read.inverted}};
  add_box(mesh.vertices, json);
  json["volume_m3"] = volume(mesh);
  if (mesh.corners == 4) {
    const MeshQuality quality = measure_quality(mesh);
    json.update({{"shortest_edge_m", quality.shortest_edge},
                 {"longest_edge_m", quality.longest_edge},
                 {"smallest_dihedral_deg", quality.min_dihedral},
                 {"largest_dihedral_deg", quality.max_dihedral}});
  } else {
    add_edges(mesh.vertices, hexahedron_edges(mesh), json);
  }
  json["regions"] = describe_regions(mesh);
  if (!read.notes.empty()) json["notes"] = read.notes;
  return json;
}

Json describe_surface(const Exec& exec, const std::string& path, double scale) {
  const ReadSurface read = required(read_surface(path, scale));
  const TriMesh& mesh = read.mesh;
  const Result<CheckedSurface> closed = check_surface(exec, mesh);
  double area = 0;
  std::vector<std::pair<int, int>> edges;
  for (const auto [a, b, c] : mesh.triangles) {
    const auto x = [&](int v) { return Vec3d(mesh.vertices[std::size_t(v)]); };
    area += norm(cross(x(b) - x(a), x(c) - x(a))) / 2;
    edges.insert(edges.end(), {{a, b}, {b, c}, {c, a}});
  }
  Json json{{"path", path},
            {"format", read.format},
            {"kind", "triangles"},
            {"vertices", mesh.vertices.size()},
            {"elements", mesh.triangles.size()},
            {"closed", bool(closed)}};
  add_box(mesh.vertices, json);
  json["area_m2"] = area;
  if (closed) json["volume_m3"] = closed->volume;
  add_edges(mesh.vertices, edges, json);
  std::vector<std::string> notes = read.notes;
  if (closed) notes.insert(notes.end(), closed->notes.begin(), closed->notes.end());
  if (!closed) notes.push_back("not a closed surface of a body: " + closed.error().message);
  if (!notes.empty()) json["notes"] = notes;
  return json;
}

void print_row(const char* name, const std::string& text) { print_plain("  {:<12} {}\n", name, text); }

std::string point_text(const Json& json, const char* key) {
  const Json& v = json[key];
  return fmt::format("{:.6g}, {:.6g}, {:.6g} m", v[0].get<double>(), v[1].get<double>(), v[2].get<double>());
}

void print_regions(const Json& regions) {
  if (regions.size() == 1 && regions[0]["region"] == 0) return;
  for (const Json& r : regions) {
    const std::size_t count = r["elements"].get<std::size_t>();
    print_row("region", fmt::format("{}: {} element{}, {:.6g} mL", r["region"].get<int>(), count,
                                    count == 1 ? "" : "s", r["volume_m3"].get<double>() * 1e6));
  }
}

}  // namespace

bool is_mesh_file(const std::string& path) { return is_solid_file(path) || is_surface_file(path); }

Json describe_mesh(const Exec& exec, const std::string& path, double scale) {
  return is_solid_file(path) ? describe_solid(path, scale) : describe_surface(exec, path, scale);
}

void print_mesh(const Json& json) {
  const auto number = [&](const char* key) { return json[key].get<double>(); };
  print_plain("{}\n", json["path"].get<std::string>());
  print_row("format", json["format"].get<std::string>());
  print_row("elements", fmt::format("{} {}, {} vertices", json["elements"].get<std::size_t>(),
                                    json["kind"].get<std::string>(), json["vertices"].get<std::size_t>()));
  if (json.contains("components"))
    print_row("components", fmt::format("{}, surface of {} triangles", json["components"].get<int>(),
                                        json["surface_triangles"].get<std::size_t>()));
  print_row("from", point_text(json, "box_from_m"));
  print_row("to", point_text(json, "box_to_m"));
  if (json.contains("area_m2")) print_row("area", fmt::format("{:.6g} cm²", number("area_m2") * 1e4));
  if (json.contains("volume_m3")) print_row("volume", fmt::format("{:.6g} mL", number("volume_m3") * 1e6));
  print_row("edges", fmt::format("{:.4g} to {:.4g} mm", number("shortest_edge_m") * 1e3,
                                 number("longest_edge_m") * 1e3));
  if (json.contains("smallest_dihedral_deg"))
    print_row("angles", fmt::format("{:.2f} to {:.2f} degrees between faces", number("smallest_dihedral_deg"),
                                    number("largest_dihedral_deg")));
  if (json.contains("closed")) print_row("closed", json["closed"].get<bool>() ? "yes" : "no");
  if (json.contains("regions")) print_regions(json["regions"]);
  if (json.contains("notes"))
    for (const Json& note : json["notes"]) print_row("note", note.get<std::string>());
}

}  // namespace turgor

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/io/mesh/surface_animation.hpp"

namespace turgor {

namespace {

using UsdText = fmt::memory_buffer;

template <class... Values>
void put(UsdText& text, fmt::format_string<Values...> format, Values&&... values) {
  fmt::format_to(std::back_inserter(text), format, std::forward<Values>(values)...);
}

/// Array of vectors: [(x, y, z), …], with the shortest digits that give the same numbers.
void put_vectors(UsdText& text, const std::vector<Vec3>& vectors) {
  put(text, "[");
  for (std::size_t i = 0; i < vectors.size(); i++)
    put(text, "{}({}, {}, {})", i > 0 ? ", " : "", vectors[i].x, vectors[i].y, vectors[i].z);
  put(text, "]");
}

/// Smallest and largest coordinates.
void put_extent(UsdText& text, const std::vector<Vec3>& points) {
  if (points.empty()) return put(text, "[]");
  Vec3 low = points[0], high = points[0];
  for (const Vec3 p : points)
    for (int axis = 0; axis < 3; axis++)
      low[axis] = std::min(low[axis], p[axis]), high[axis] = std::max(high[axis], p[axis]);
  put_vectors(text, {low, high});
}

void put_corners(UsdText& text, const std::vector<Int3>& triangles) {
  put(text, "[");
  for (std::size_t i = 0; i < triangles.size(); i++)
    put(text, "{}{}, {}, {}", i > 0 ? ", " : "", triangles[i].x, triangles[i].y, triangles[i].z);
  put(text, "]");
}

void put_counts(UsdText& text, std::size_t triangles) {
  put(text, "[");
  for (std::size_t i = 0; i < triangles; i++) put(text, "{}", i > 0 ? ", 3" : "3");
  put(text, "]");
}

/// Frame of the simulation at a sample.
double time_code(const SurfaceAnimation& animation, std::size_t sample) {
  constexpr double kRounding = 1e-6;  // of a frame
  const double code = animation.times[sample] * animation.frame_rate, frame = std::round(code);
  return std::abs(code - frame) < kRounding ? frame : code;
}

/// Attribute with a value at these samples.
template <class PutValue>
void put_samples(UsdText& text, const SurfaceAnimation& animation, const std::string& attribute,
                 const std::vector<std::size_t>& samples, PutValue put_value) {
  put(text, "        {}.timeSamples = {{\n", attribute);
  for (const std::size_t s : samples) {
    put(text, "            {}: ", time_code(animation, s));
    put_value(s);
    put(text, ",\n");
  }
  put(text, "        }}\n");
}

/// Text in quotes.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += std::iscntrl(static_cast<unsigned char>(c)) ? ' ' : c;
  }
  return out + "\"";
}

void put_mesh(UsdText& text, const SurfaceAnimation& animation, const AnimatedSurface& surface,
              const std::string& name) {
  TURGOR_ASSERT(surface.samples.size() == animation.times.size(), "a surface has one sample a time");
  // samples with new triangles
  std::vector<std::size_t> all, changed;
  bool has_normals = true;
  for (std::size_t s = 0; s < surface.samples.size(); s++) {
    all.push_back(s);
    if (s == 0 || surface.samples[s].triangulation != surface.samples[s - 1].triangulation)
      changed.push_back(s);
    has_normals = has_normals && surface.samples[s].normals.size() == surface.samples[s].points.size();
  }
  const auto triangles = [&](std::size_t s) -> const std::vector<Int3>& {
    return surface.triangulations[surface.samples[s].triangulation];
  };

  // attributes
  put(text, "    def Mesh \"{}\" (\n        prepend apiSchemas = [\"MaterialBindingAPI\"]\n", name);
  put(text, "        displayName = {}\n    )\n    {{\n", quoted(surface.name));
  put(text, "        uniform bool doubleSided = {}\n", surface.look.two_sided ? 1 : 0);
  put(text, "        uniform token orientation = \"rightHanded\"\n");
  put(text, "        uniform token subdivisionScheme = \"none\"\n");
  if (const Vec3 color = surface.look.color; !has_point_colors(surface)) {
    put(text, "        color3f[] primvars:displayColor = [({}, {}, {})]\n", color.x, color.y, color.z);
  } else {
    put(text,
        "        color3f[] primvars:displayColor (\n            interpolation = \"vertex\"\n        )\n");
    put_samples(text, animation, "color3f[] primvars:displayColor", changed,
                [&](std::size_t s) { put_vectors(text, point_colors(surface, surface.samples[s])); });
  }
  put(text, "        float[] primvars:displayOpacity = [{}]\n", surface.look.opacity);
  put(text, "        rel material:binding = </Turgor/Materials/{}>\n", name);
  put_samples(text, animation, "float3[] extent", all,
              [&](std::size_t s) { put_extent(text, surface.samples[s].points); });
  put_samples(text, animation, "int[] faceVertexCounts", changed,
              [&](std::size_t s) { put_counts(text, triangles(s).size()); });
  put_samples(text, animation, "int[] faceVertexIndices", changed,
              [&](std::size_t s) { put_corners(text, triangles(s)); });
  put_samples(text, animation, "point3f[] points", all,
              [&](std::size_t s) { put_vectors(text, surface.samples[s].points); });
  if (has_normals) {
    put(text, "        normal3f[] normals (\n            interpolation = \"vertex\"\n        )\n");
    put_samples(text, animation, "normal3f[] normals", all,
                [&](std::size_t s) { put_vectors(text, surface.samples[s].normals); });
  }
  put(text, "    }}\n\n");
}

void put_material(UsdText& text, const AnimatedSurface& surface, const std::string& name) {
  const SurfaceLook& look = surface.look;
  const std::string path = fmt::format("/Turgor/Materials/{}", name);
  put(text, "        def Material \"{}\"\n        {{\n", name);
  put(text, "            token outputs:surface.connect = <{}/Shader.outputs:surface>\n\n", path);
  put(text, "            def Shader \"Shader\"\n            {{\n");
  put(text, "                uniform token info:id = \"UsdPreviewSurface\"\n");
  if (has_point_colors(surface))
    put(text, "                color3f inputs:diffuseColor.connect = <{}/Colors.outputs:result>\n", path);
  else
    put(text, "                color3f inputs:diffuseColor = ({}, {}, {})\n", look.color.x, look.color.y,
        look.color.z);
  put(text, "                float inputs:opacity = {}\n", look.opacity);
  put(text, "                float inputs:roughness = 0.6\n");
  put(text, "                token outputs:surface\n            }}\n");
  if (has_point_colors(surface)) {
    put(text, "\n            def Shader \"Colors\"\n            {{\n");
    put(text, "                uniform token info:id = \"UsdPrimvarReader_float3\"\n");
    put(text, "                string inputs:varname = \"displayColor\"\n");
    put(text, "                float3 outputs:result\n            }}\n");
  }
  put(text, "        }}\n");
}

void put_header(UsdText& text, const SurfaceAnimation& animation) {
  TURGOR_ASSERT(!animation.times.empty(), "an animation has a time");
  put(text, "#usda 1.0\n(\n    defaultPrim = \"Turgor\"\n");
  put(text, "    doc = \"Surfaces of turgor: meters, patient frame LPS (z to the head)\"\n");
  put(text, "    endTimeCode = {}\n", time_code(animation, animation.times.size() - 1));
  put(text, "    framesPerSecond = {}\n    metersPerUnit = 1\n", animation.frame_rate);
  put(text, "    startTimeCode = {}\n", time_code(animation, 0));
  put(text, "    timeCodesPerSecond = {}\n    upAxis = \"Z\"\n)\n\n", animation.frame_rate);
  put(text, "def Xform \"Turgor\" (\n    kind = \"component\"\n)\n{{\n");
}

}  // namespace

std::vector<std::string> usd_names(const SurfaceAnimation& animation) {
  std::vector<std::string> names;
  std::set<std::string> used{"Materials"};
  for (const AnimatedSurface& surface : animation.surfaces) {
    std::string name = surface.name;
    for (char& c : name)
      if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
    if (name.empty() || std::isdigit(static_cast<unsigned char>(name[0]))) name = "_" + name;
    const std::string stem = name;
    for (int n = 2; !used.insert(name).second; n++) name = fmt::format("{}_{}", stem, n);
    names.push_back(name);
  }
  return names;
}

Status write_usda(const std::filesystem::path& path, const SurfaceAnimation& animation) {
  Result<FileWriter> file = FileWriter::create(path);
  if (!file) return file.error();
  const std::vector<std::string> names = usd_names(animation);
  UsdText text;
  const auto flush = [&] { file->write({text.data(), text.size()}), text.clear(); };
  put_header(text, animation);
  for (std::size_t i = 0; i < names.size(); i++) {
    put_mesh(text, animation, animation.surfaces[i], names[i]);
    flush();
  }
  put(text, "    def Scope \"Materials\"\n    {{\n");
  for (std::size_t i = 0; i < names.size(); i++) put_material(text, animation.surfaces[i], names[i]);
  put(text, "    }}\n}}\n");
  flush();
  return file->commit();
}

void add_sample(TriMesh mesh, AnimatedSurface& surface, std::vector<Vec3> colors) {
  TURGOR_ASSERT(colors.empty() || colors.size() == mesh.vertices.size(), "one color a point, or none");
  ShapeSample sample{.points = std::move(mesh.vertices), .normals = std::move(mesh.normals)};
  // glTF permits unit normals only, also at points without triangles
  for (Vec3& n : sample.normals)
    if (!(dot(n, n) > 0)) n = {0, 0, 1};
  const bool same = !surface.samples.empty() &&
                    surface.samples.back().points.size() == sample.points.size() &&
                    surface.triangulations.back() == mesh.triangles && surface.colors.back() == colors;
  if (!same)
    surface.triangulations.push_back(std::move(mesh.triangles)), surface.colors.push_back(std::move(colors));
  sample.triangulation = surface.triangulations.size() - 1;
  surface.samples.push_back(std::move(sample));
}

bool has_point_colors(const AnimatedSurface& surface) {
  return std::any_of(surface.colors.begin(), surface.colors.end(),
                     [](const std::vector<Vec3>& colors) { return !colors.empty(); });
}

std::vector<Vec3> point_colors(const AnimatedSurface& surface, const ShapeSample& sample) {
  const std::vector<Vec3>& colors = surface.colors[sample.triangulation];
  return colors.empty() ? std::vector<Vec3>(sample.points.size(), surface.look.color) : colors;
}

}  // namespace turgor

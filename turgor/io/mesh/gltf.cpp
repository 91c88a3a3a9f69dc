#include <algorithm>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "turgor/core/assert.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/io/mesh/surface_animation.hpp"

namespace turgor {

namespace {

using GltfJson = nlohmann::json;

// Codes of glTF 2.0.
constexpr int kFloat = 5126, kUnsigned = 5125, kArrayBuffer = 34962, kElementBuffer = 34963;
constexpr std::uint32_t kGlbMagic = 0x46546C67, kGlbVersion = 2, kJsonChunk = 0x4E4F534A,
                        kBinaryChunk = 0x004E4942;

/// Content of a file so far.
struct Glb {
  std::string bytes;  // of the binary chunk
  GltfJson views = GltfJson::array(), accessors = GltfJson::array(), materials = GltfJson::array(),
           meshes = GltfJson::array(), nodes = GltfJson::array(), samplers = GltfJson::array(),
           channels = GltfJson::array();
};

int add_to(GltfJson& list, GltfJson item) {
  list.push_back(std::move(item));
  return int(list.size()) - 1;
}

/// Adds numbers to the binary chunk; returns their accessor. All types have a multiple of 4 bytes.
template <class T>
int add_numbers(const std::vector<T>& values, int component, const char* type, std::optional<int> target,
                Glb& glb) {
  static_assert(sizeof(T) % 4 == 0);
  const std::size_t size = values.size() * sizeof(T), columns = sizeof(T) / 4;
  GltfJson view{{"buffer", 0}, {"byteOffset", glb.bytes.size()}, {"byteLength", size}};
  if (target) view["target"] = *target;
  glb.bytes.append(reinterpret_cast<const char*>(values.data()), size);
  const bool scalar = std::string_view(type) == "SCALAR";
  return add_to(glb.accessors, {{"bufferView", add_to(glb.views, std::move(view))},
                                {"componentType", component},
                                {"count", values.size() * (scalar ? columns : 1)},
                                {"type", type}});
}

int add_vectors(const std::vector<Vec3>& vectors, bool with_limits, std::optional<int> target, Glb& glb) {
  static_assert(sizeof(Vec3) == 3 * sizeof(float));
  const int accessor = add_numbers(vectors, kFloat, "VEC3", target, glb);
  if (!with_limits) return accessor;
  Vec3 low = vectors.at(0), high = vectors.at(0);
  for (const Vec3 v : vectors)
    for (int axis = 0; axis < 3; axis++)
      low[axis] = std::min(low[axis], v[axis]), high[axis] = std::max(high[axis], v[axis]);
  glb.accessors.back()["min"] = {low.x, low.y, low.z};
  glb.accessors.back()["max"] = {high.x, high.y, high.z};
  return accessor;
}

int add_times(const std::vector<float>& times, Glb& glb) {
  const int accessor = add_numbers(times, kFloat, "SCALAR", std::nullopt, glb);
  glb.accessors.back()["min"] = {times.front()};
  glb.accessors.back()["max"] = {times.back()};
  return accessor;
}

std::vector<Vec3> differences(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  std::vector<Vec3> out(a.size());
  for (std::size_t i = 0; i < a.size(); i++) out[i] = a[i] - b[i];
  return out;
}

/// Samples [begin, end) of a surface with the same triangles.
struct Interval {
  const AnimatedSurface& surface;
  std::size_t begin, end;
};

/// Calls take(interval) for each interval of a surface that has triangles.
void for_each_interval(const AnimatedSurface& surface, const std::function<void(const Interval&)>& take) {
  const std::vector<ShapeSample>& samples = surface.samples;
  for (std::size_t begin = 0, end = 0; begin < samples.size(); begin = end) {
    const std::size_t triangulation = samples[begin].triangulation;
    while (end < samples.size() && samples[end].triangulation == triangulation) end++;
    if (!surface.triangulations[triangulation].empty()) take({surface, begin, end});
  }
}

/// True if all samples of an interval have normals.
bool all_have_normals(const Interval& interval) {
  const auto begin = interval.surface.samples.begin();
  return std::all_of(begin + std::ptrdiff_t(interval.begin), begin + std::ptrdiff_t(interval.end),
                     [](const ShapeSample& sample) { return sample.normals.size() == sample.points.size(); });
}

/// Times at which an interval changes its visibility, as animate_visibility writes them.
std::size_t visibility_keys(const Interval& interval) {
  const bool begins = interval.begin > 0, ends = interval.end < interval.surface.samples.size();
  return begins || ends ? 1 + std::size_t(begins) + std::size_t(ends) : 0;
}

/// Numbers of 4 bytes in the mesh and the animations of an interval.
std::uint64_t number_count(const Interval& interval) {
  const ShapeSample& base = interval.surface.samples[interval.begin];
  const std::uint64_t samples = interval.end - interval.begin, points = base.points.size(),
                      triangles = interval.surface.triangulations[base.triangulation].size(),
                      vectors = samples * (all_have_normals(interval) ? 2 : 1) +
                                (has_point_colors(interval.surface) ? 1 : 0),
                      weights = samples > 1 ? samples * (samples - 1) : 0, times = samples > 1 ? samples : 0;
  return 3 * points * vectors + 3 * triangles + times + weights + 4 * visibility_keys(interval);
}

/// Mesh of an interval: its first sample, and a morph target for each of the others.
int add_mesh(const Interval& interval, const std::string& name, int material, Glb& glb) {
  const std::vector<ShapeSample>& samples = interval.surface.samples;
  const ShapeSample& base = samples[interval.begin];
  const bool with_normals = all_have_normals(interval);

  // first sample
  GltfJson attributes{{"POSITION", add_vectors(base.points, true, kArrayBuffer, glb)}};
  if (with_normals) attributes["NORMAL"] = add_vectors(base.normals, false, kArrayBuffer, glb);
  if (has_point_colors(interval.surface))
    attributes["COLOR_0"] = add_vectors(point_colors(interval.surface, base), false, kArrayBuffer, glb);
  std::vector<std::uint32_t> corners;
  for (const Int3 t : interval.surface.triangulations[base.triangulation])
    corners.insert(corners.end(), {std::uint32_t(t.x), std::uint32_t(t.y), std::uint32_t(t.z)});
  const int indices = add_numbers(corners, kUnsigned, "SCALAR", kElementBuffer, glb);
  GltfJson primitive{{"attributes", attributes}, {"indices", indices}, {"material", material}};

  // morph targets
  GltfJson targets = GltfJson::array();
  for (std::size_t s = interval.begin + 1; s < interval.end; s++) {
    GltfJson target{
        {"POSITION", add_vectors(differences(samples[s].points, base.points), true, kArrayBuffer, glb)}};
    if (with_normals)
      target["NORMAL"] = add_vectors(differences(samples[s].normals, base.normals), false, kArrayBuffer, glb);
    targets.push_back(std::move(target));
  }
  GltfJson mesh{{"name", name}};
  if (!targets.empty()) {
    mesh["weights"] = std::vector<float>(targets.size(), 0.0f);
    primitive["targets"] = std::move(targets);
  }
  mesh["primitives"] = GltfJson::array({std::move(primitive)});
  return add_to(glb.meshes, std::move(mesh));
}

void add_channel(int node, const char* path, const char* interpolation, int input, int output, Glb& glb) {
  const int sampler =
      add_to(glb.samplers, {{"input", input}, {"output", output}, {"interpolation", interpolation}});
  add_to(glb.channels, {{"sampler", sampler}, {"target", {{"node", node}, {"path", path}}}});
}

/// Weights of the morph targets: at each sample its own target has weight 1. Linear interpolation of weights
/// is linear interpolation of positions.
void animate_shape(const Interval& interval, const std::vector<float>& times, int node, Glb& glb) {
  const std::size_t count = interval.end - interval.begin;
  if (count < 2) return;
  std::vector<float> weights(count * (count - 1), 0.0f);
  for (std::size_t s = 1; s < count; s++) weights[s * (count - 1) + s - 1] = 1;
  const auto at = times.begin();
  const int input = add_times({at + std::ptrdiff_t(interval.begin), at + std::ptrdiff_t(interval.end)}, glb);
  add_channel(node, "weights", "LINEAR", input, add_numbers(weights, kFloat, "SCALAR", std::nullopt, glb),
              glb);
}

/// Shows an interval from its first sample to the first one of the next interval, by a scale of 1 or 0.
void animate_visibility(const Interval& interval, const std::vector<float>& times, int node, Glb& glb) {
  const bool begins = interval.begin > 0, ends = interval.end < times.size();
  if (visibility_keys(interval) == 0) return;
  std::vector<float> keys;
  std::vector<Vec3> scales;
  const auto add_key = [&](std::size_t sample, float scale) {
    keys.push_back(times[sample]), scales.push_back({scale, scale, scale});
  };
  if (begins) add_key(0, 0);
  add_key(interval.begin, 1);
  if (ends) add_key(interval.end, 0);
  const int input = add_times(keys, glb);
  add_channel(node, "scale", "STEP", input, add_vectors(scales, false, std::nullopt, glb), glb);
  if (begins) glb.nodes[std::size_t(node)]["scale"] = {0, 0, 0};
}

/// Nodes of a surface, one for each of its triangulations.
void add_surface(const AnimatedSurface& surface, const std::vector<float>& times, Glb& glb,
                 GltfJson& children) {
  TURGOR_ASSERT(surface.samples.size() == times.size(), "a surface has one sample a time");
  const SurfaceLook& look = surface.look;
  const Vec3 color =
      has_point_colors(surface) ? Vec3{1, 1, 1} : look.color;  // a factor of the points' colors
  GltfJson material{{"name", surface.name},
                    {"doubleSided", look.two_sided},
                    {"pbrMetallicRoughness",
                     {{"baseColorFactor", {color.x, color.y, color.z, look.opacity}},
                      {"metallicFactor", 0},
                      {"roughnessFactor", 0.6}}}};
  if (look.opacity < 1) material["alphaMode"] = "BLEND";
  const int material_index = add_to(glb.materials, std::move(material));
  int intervals = 0;
  for_each_interval(surface, [&](const Interval& interval) {
    intervals++;
    const std::string name = intervals == 1 ? surface.name : fmt::format("{} {}", surface.name, intervals);
    const int mesh = add_mesh(interval, name, material_index, glb);
    const int node = add_to(glb.nodes, {{"name", name}, {"mesh", mesh}});
    children.push_back(node);
    animate_shape(interval, times, node, glb);
    animate_visibility(interval, times, node, glb);
  });
}

std::string bytes_of_words(std::initializer_list<std::uint32_t> words) {
  return {reinterpret_cast<const char*>(words.begin()), words.size() * sizeof(std::uint32_t)};
}

Error too_large_glb(std::uint64_t size, std::uint64_t most_bytes) {
  const auto gib = [](std::uint64_t bytes) { return double(bytes) / double(1 << 30); };
  return {
      fmt::format("expected at most {:.3g} GiB in a file of glTF, found {:.3g} GiB; USD has no such limit, "
                  "or raise output.snapshots.every",
                  gib(most_bytes), gib(size))};
}

Error glb_error(const std::filesystem::path& path, const Error& error) {
  return {fmt::format("{}: {}", path.string(), error.message)};
}

Status write_chunks(const std::filesystem::path& path, const GltfJson& json, const std::string& bytes,
                    std::uint64_t most_bytes) {
  std::string text = json.dump(-1, ' ', false, GltfJson::error_handler_t::replace);
  text.resize((text.size() + 3) / 4 * 4, ' ');
  constexpr std::size_t kHeaders = 28;
  const std::size_t size = kHeaders + text.size() + bytes.size();
  if (size > std::min(most_bytes, kMostGlbBytes)) return glb_error(path, too_large_glb(size, most_bytes));
  Result<FileWriter> file = FileWriter::create(path);
  if (!file) return file.error();
  file->write(bytes_of_words({kGlbMagic, kGlbVersion, std::uint32_t(size)}));
  file->write(bytes_of_words({std::uint32_t(text.size()), kJsonChunk}));
  file->write(text);
  file->write(bytes_of_words({std::uint32_t(bytes.size()), kBinaryChunk}));
  file->write(bytes);
  return file->commit();
}

}  // namespace

std::uint64_t glb_bytes(const SurfaceAnimation& animation) {
  std::uint64_t numbers = 0;
  for (const AnimatedSurface& surface : animation.surfaces)
    for_each_interval(surface, [&](const Interval& interval) { numbers += number_count(interval); });
  return 4 * numbers;
}

Status check_glb(const SurfaceAnimation& animation, std::uint64_t most_bytes) {
  if (animation.times.size() > kMostGltfSamples)
    return Error{
        fmt::format("expected at most {} snapshots for glTF, found {}; USD has no such limit, or raise "
                    "output.snapshots.every",
                    kMostGltfSamples, animation.times.size())};
  const std::uint64_t bytes = glb_bytes(animation);
  return bytes > most_bytes ? Status(too_large_glb(bytes, most_bytes)) : Status(Done{});
}

Status write_glb(const std::filesystem::path& path, const SurfaceAnimation& animation,
                 std::uint64_t most_bytes) {
  if (const Status fits = check_glb(animation, most_bytes); !fits) return glb_error(path, fits.error());
  // root node: half a right angle's sine and cosine, a quarter turn about x from z up to y up
  constexpr double kHalf = 0.70710678118654752;
  Glb glb;
  add_to(glb.nodes, {{"name", "patient"}, {"rotation", {-kHalf, 0, 0, kHalf}}});
  const std::vector<float> times(animation.times.begin(), animation.times.end());
  GltfJson children = GltfJson::array();
  for (const AnimatedSurface& surface : animation.surfaces) add_surface(surface, times, glb, children);
  if (!children.empty()) glb.nodes[0]["children"] = children;

  // document, without empty lists, which glTF forbids
  GltfJson json{{"asset", {{"version", "2.0"}, {"generator", "turgor"}}},
                {"scene", 0},
                {"scenes", GltfJson::array({{{"nodes", {0}}}})},
                {"nodes", glb.nodes}};
  const auto add_list = [&](const char* key, GltfJson& list) {
    if (!list.empty()) json[key] = std::move(list);
  };
  add_list("meshes", glb.meshes);
  add_list("materials", glb.materials);
  add_list("accessors", glb.accessors);
  add_list("bufferViews", glb.views);
  if (!glb.bytes.empty()) json["buffers"] = GltfJson::array({{{"byteLength", glb.bytes.size()}}});
  if (!glb.channels.empty())
    json["animations"] = GltfJson::array(
        {{{"name", "run"}, {"channels", std::move(glb.channels)}, {"samplers", std::move(glb.samplers)}}});
  TURGOR_CHECK(glb.bytes.size() == glb_bytes(animation), "the size of the binary chunk is known");
  return write_chunks(path, json, glb.bytes, most_bytes);
}

}  // namespace turgor

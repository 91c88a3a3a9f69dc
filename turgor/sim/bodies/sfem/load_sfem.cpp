#include "turgor/sim/bodies/sfem/load_sfem.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/gpu.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/geometry/organ_mesh.hpp"
#include "turgor/geometry/quadratic.hpp"
#include "turgor/io/ct.hpp"
#include "turgor/io/mesh/solid_files.hpp"
#include "turgor/io/mesh/surface_files.hpp"
#include "turgor/io/mesh/unit_question.hpp"
#include "turgor/sim/bodies/sfem/choose_patch.hpp"
#include "turgor/sim/bodies/sfem/green_cache.hpp"
#include "turgor/sim/bodies/sfem/make_body.hpp"
#include "turgor/sim/scene/scene_sfem.hpp"
#include "turgor/sim/world.hpp"

namespace turgor {

namespace {

constexpr double kLeastPatchMemory = 0.25;  // memory that a patch may always use [GB]

void append(std::vector<std::string>& notes, const std::vector<std::string>& more) {
  notes.insert(notes.end(), more.begin(), more.end());
}

Result<OrganMesh> from_solid_file(const SolidFile& source) {
  Result<ReadSolid> read = read_solid(source.file, source.scale);
  if (!read) return read.error();
  if (const Status unit = check_unit(source.file, read->mesh.vertices, source.is_scale_given); !unit)
    return unit.error();
  turn_up(read->mesh.vertices, source.up);
  return OrganMesh{.mesh = std::move(read->mesh), .notes = std::move(read->notes)};
}

/// Progress of meshing: a sentence with the expected count once it is known, then fractions.
class Meshing {
 public:
  Meshing(const BeginWork& begin, const std::string& body, bool is_size_given) {
    if (!is_size_given) bound.edges = kEdgesAcross;
    bound.begin = [this, &begin, &body](const MeshForecast& forecast) {
      const double digits = std::pow(10.0, std::max(0.0, std::floor(std::log10(forecast.elements)) - 1));
      bar_ = begin_work(begin, "meshing",
                        fmt::format("{}: meshing, about {:.0f} tetrahedra", body,
                                    std::round(forecast.elements / digits) * digits));
    };
    progress = [this](double fraction) {
      if (bar_) bar_(fraction);
    };
  }
  Meshing(const Meshing&) = delete;
  Meshing& operator=(const Meshing&) = delete;

  MeshBound bound;
  Progress progress;

 private:
  Progress bar_;
};

Result<OrganMesh> from_surface(const Exec& exec, const std::string& body, const ClosedSurface& source,
                               Sides sides, const BeginWork& begin) {
  Result<ReadSurface> read = read_surface(source.file, source.scale);
  if (!read) return read.error();
  if (const Status unit = check_unit(source.file, read->mesh.vertices, source.is_scale_given); !unit)
    return unit.error();
  turn_up(read->mesh.vertices, source.up);
  const Meshing meshing(begin, body, source.resolution.has_value());
  Result<OrganMesh> made = mesh_of_surface(exec, read->mesh, source.resolution.value_or(kUsualEdge),
                                           meshing.progress, sides, meshing.bound);
  if (!made) return Error{fmt::format("{}: {}", source.file.string(), made.error().message)};
  append(made->notes, read->notes);
  return made;
}

Result<OrganMesh> from_labels(const Exec& exec, const SfemScene& scene, const LabeledOrgan& source,
                              Sides sides, const BeginWork& begin) {
  LabelVolume labels;
  if (source.phantom) {
    make_phantom(exec, *source.phantom, &labels, begin_work(begin, "painting"));
  } else {
    Result<LabelFile> read = read_labels(source.file);
    if (!read) return read.error();
    labels = std::move(read->labels);
  }
  TURGOR_CHECK(source.label >= 0, "a label file holds labels from 0");
  std::vector<int> selected{source.label};
  for (const InsideScene& region : scene.inside) selected.push_back(region.label);
  const Meshing meshing(begin, scene.name, source.resolution.has_value());
  Result<OrganMesh> made =
      mesh_of_labels(exec, labels, selected, source.resolution.value_or(kUsualEdge), meshing.progress, sides,
                     meshing.bound, {source.are_cavities_filled, source.of_others});
  const std::string name = source.phantom ? "the phantom" : source.file.string();
  if (!made) return Error{fmt::format("{}: {}", name, made.error().message)};
  if (!source.label_note.empty()) made->notes.push_back(source.label_note);
  return made;
}

OrganMesh block_at(const HexBlock& block) {
  OrganMesh made{.mesh = hex_block(block.size, block.count)};
  for (Vec3d& x : made.mesh.vertices) x += block.corner;
  return made;
}

Result<OrganMesh> load_shape(const Exec& exec, const SfemScene& scene, const BeginWork& begin) {
  if (const auto* file = std::get_if<SolidFile>(&scene.source)) return from_solid_file(*file);
  const Sides sides = scene.elements == Elements::kQuadratic ? Sides::kCurved : Sides::kFlat;
  if (const auto* surface = std::get_if<ClosedSurface>(&scene.source))
    return from_surface(exec, scene.name, *surface, sides, begin);
  if (const auto* body = std::get_if<LabeledOrgan>(&scene.source))
    return from_labels(exec, scene, *body, sides, begin);
  const HexBlock& block = std::get<HexBlock>(scene.source);
  return block_at(block);
}

SolidMesh corner_tetrahedra(const SolidMesh& mesh) {
  return mesh.corners == 10 ? without_middles(mesh) : mesh;
}

double longest_edge(const SolidMesh& mesh) {
  double longest = 0;
  for (std::size_t e = 0; e < element_count(mesh); e++) {
    const auto corners = element(mesh, e);
    for (const int a : corners)
      for (const int b : corners)
        longest = std::max(longest, norm(mesh.vertices[std::size_t(a)] - mesh.vertices[std::size_t(b)]));
  }
  return longest;
}

std::string memory_text(double bytes) {
  return bytes < 1e9 ? fmt::format("{:.0f} MB", bytes / 1e6) : fmt::format("{:.1f} GB", bytes / 1e9);
}

/// Columns on demand: the store exceeds the memory limit, the factor does not.
Status prepare_on_demand(const Exec& exec, const SfemScene& scene, SfemBody& body, const BeginWork& begin) {
  // check that the factor fits
  const sfem::GreenCost& cost = body.facts.cost;
  if (double(cost.factor_bytes) > scene.memory * 1e9)
    return Error{
        fmt::format("{}: the body's factor alone takes {}, the limit is {} GB: raise body.{}.memory, or use "
                    "a coarser mesh",
                    scene.source_location, memory_text(double(cost.factor_bytes)), scene.memory, scene.name)};
  // note the reason
  body.facts.on_demand = true;
  body.facts.notes.push_back(fmt::format(
      "all Green's functions would take {}, the limit is {} GB: their columns are computed on demand at "
      "the tools; more memory or a coarser mesh makes patches faster",
      memory_text(double(cost.store_bytes)), scene.memory));
  // factorize
  return sfem::prepare_columns(
      exec, body.model,
      begin_work(begin, "factor",
                 fmt::format("{}: {} nodes, factor of {}, columns of Green's functions on demand", body.name,
                             body.model.vertex.size(), memory_text(double(cost.factor_bytes)))));
}

Status compute_and_keep(const Exec& exec, const SfemScene& scene, const std::filesystem::path& cache,
                        SfemBody& body, const BeginWork& begin) {
  const sfem::GreenCost& cost = body.facts.cost;
  const Progress progress = begin_work(
      begin, "Green's functions",
      fmt::format("{}: {} free nodes; Green's functions between {} of them take {}, the factor {}; {:.3g} "
                  "thousand million operations",
                  body.name, body.model.vertex.size(), body.model.green.nodes.size(),
                  memory_text(double(cost.store_bytes)), memory_text(double(cost.factor_bytes)),
                  (cost.factor_flops + cost.solve_flops) * 1e-9));
  std::optional<Gpu> gpu;
  if (scene.device == Device::kGpu) {
    const Result<Gpu> found = open_gpu();
    if (!found)
      return Error{fmt::format("{}: device = \"gpu\": {}", scene.source_location, found.error().message)};
    gpu = *found;
    body.facts.notes.push_back("Green's functions were computed on " + gpu->name);
  }
  if (const Status status = sfem::compute_green(exec, body.model, std::size_t(scene.memory * 1e9), progress,
                                                gpu ? &*gpu : nullptr);
      !status)
    return Error{fmt::format("{}: {}", scene.source_location, status.error().message)};
  if (cache.empty()) return Done{};
  const Status kept = write_green(cache, body.model, scene.source_location);
  if (!kept) body.facts.notes.push_back("not cached: " + kept.error().message);
  return Done{};
}

/// Removes least recently used files from a cache that exceeds its limit.
void keep_within_limit(const std::filesystem::path& cache, std::vector<std::string>& notes) {
  const Result<std::uintmax_t> limit = cache_limit();
  if (!limit) return notes.push_back(limit.error().message + "; the cache is not trimmed");
  const std::vector<CacheFile> removed = trim_cache(cache.parent_path(), *limit, cache);
  if (removed.empty()) return;
  double bytes = 0;
  for (const CacheFile& file : removed) bytes += double(file.bytes);
  notes.push_back(fmt::format(
      "{}: {} least recently used files of {} were removed: the limit is {} "
      "(TURGOR_CACHE_LIMIT, in GB)",
      cache.parent_path().string(), removed.size(), memory_text(bytes), memory_text(double(*limit))));
}

Status prepare_green(const Exec& exec, const SfemScene& scene, SfemBody& body, const BeginWork& begin) {
  // cost and identity
  const Timer timer;
  body.facts.cost = sfem::green_cost(body.model);
  body.facts.content_hash = sfem::content_hash(body.model);
  const auto& cost = body.facts.cost;
  // fall back to columns on demand
  if (double(cost.store_bytes + cost.factor_bytes) > scene.memory * 1e9) {
    const Status status = prepare_on_demand(exec, scene, body, begin);
    body.facts.green_seconds = timer.seconds();
    return status;
  }
  // locate the cache file
  const std::filesystem::path cache =
      scene.cached ? green_cache_file(scene.cache, body.facts.content_hash) : std::filesystem::path();
  body.facts.cache_file = cache.string();
  // read from the cache, or compute and store
  Status status = Done{};
  CachedGreen cached = cache.empty() ? CachedGreen{} : read_green(cache, body.model);
  if (!cached.note.empty()) body.facts.notes.push_back(cached.note);
  body.facts.from_cache = cached.found;
  const std::filesystem::path goal = cached.keep ? std::filesystem::path() : cache;
  if (!cached.found) status = compute_and_keep(exec, scene, goal, body, begin);
  if (!cached.found && !cache.empty() && status) keep_within_limit(cache, body.facts.notes);
  body.facts.green_seconds = timer.seconds();
  return status;
}

Status load_seen(const Exec& exec, const SfemScene& scene, SfemBody& body) {
  if (scene.seen.empty()) return Done{};
  // read the surface
  Result<ReadSurface> read = read_surface(scene.seen, scene.seen_scale);
  if (!read) return Error{fmt::format("{}.seen: {}", scene.source_location, read.error().message)};
  append(body.facts.notes, read->notes);
  turn_up(read->mesh.vertices, scene.seen_up);
  // embed it into the mesh
  const SolidMesh& mesh = body.model.body.mesh;
  body.seen = SeenSurface{embed(exec, read->mesh, mesh.corners == 10 ? linear_subdivision(mesh) : mesh),
                          read->mesh.triangles};
  // reject a surface that does not match the body
  const double edge = longest_edge(mesh);
  if (body.seen->embedding.farthest_outside > 3 * edge)
    return Error{
        fmt::format("{}.seen: {}: a vertex is {:.4g} m away from the body, whose longest edge is {:.4g} "
                    "m; expected a surface of the same body (seen_scale?)",
                    scene.source_location, scene.seen.string(), body.seen->embedding.farthest_outside, edge)};
  return Done{};
}

Status prepare_turning(const Exec& exec, SfemBody& body, const BeginWork& begin) {
  if (const Status s = sfem::factorize(exec, body.model, begin_work(begin, "factor")); !s) return s.error();
  body.turning = Turning{sfem::make_corotation(exec, body.model), sfem::make_rotation_state(body.model)};
  return Done{};
}

/// A body without fixed vertices begins at rest.
Status prepare_flight(const Exec& exec, SfemBody& body, const BeginWork& begin) {
  if (const Status s = sfem::factorize(exec, body.model, begin_work(begin, "factor")); !s) return s.error();
  const std::vector<Vec3d> zero(body.model.body.mesh.vertices.size());
  body.flight = FreeFlight{zero, zero, zero};
  return Done{};
}

}  // namespace

Result<SfemBody> load_body(const Loading& loading, const SfemScene& scene, const World& world) {
  const auto& [exec, begin, purpose] = loading;
  // facts that drawing needs
  SfemBody body;
  body.name = scene.name;
  body.typical_force = scene.material.young * 1e-4;
  if (purpose == Purpose::kDraw) {
    body.inside = named_regions(scene);
    return body;
  }
  // shape and mesh quality
  const Timer shaping;
  Result<OrganMesh> shape = load_shape(exec, scene, begin);
  if (!shape) return Error{fmt::format("{}: {}", scene.source_location, shape.error().message)};
  body.facts.notes = std::move(shape->notes);
  body.facts.input_volume = shape->input_volume;
  if (shape->mesh.corners != 8) body.facts.quality = measure_quality(corner_tetrahedra(shape->mesh));
  body.facts.volume = volume(shape->mesh);
  // materials
  Result<sfem::Body> elastic = make_body(std::move(shape->mesh), scene);
  if (!elastic) return elastic.error();
  body.facts.shape_seconds = shaping.seconds();

  // elastic model
  const double touch_depth =
      scene.patch.radius_is_open ? usual_touch_depth(elastic->mesh) : scene.patch.radius;
  const sfem::Params params{scene.formulation, scene.precision, touch_depth,
                            scene.is_free ? scene.density : 0, scene.is_free ? world.dt : 0};
  Result<sfem::Model> model = sfem::build(exec, std::move(*elastic), params);
  if (!model) return Error{fmt::format("{}: {}", scene.source_location, model.error().message)};
  body.model = std::move(*model);
  body.stiffness_scale = scene.stiffness_scale;
  body.inside = inner_regions(scene, body.model.body);
  body.toughness = {kNeedlesOwn};
  for (const InsideScene& inside : scene.inside) body.toughness.push_back(inside.toughness);
  for (const InclusionScene& inclusion : scene.inclusions) body.toughness.push_back(inclusion.toughness);
  body.follow.radius = scene.patch.radius;
  // Green's functions, visible surface and rotations
  if (const Status status = prepare_green(exec, scene, body, begin); !status) return status.error();
  if (const Status status = load_seen(exec, scene, body); !status) return status.error();
  if (scene.is_free)
    if (const Status status = prepare_flight(exec, body, begin); !status) return status.error();
  if (scene.rotations)
    if (const Status status = prepare_turning(exec, body, begin); !status) return status.error();
  // patch parameters
  body.radius_is_open = scene.patch.radius_is_open;
  body.refinement_is_open = scene.patch.refinement == kByElements;
  if (!body.refinement_is_open) body.refinement = scene.patch.refinement;
  TURGOR_CHECK(body.refinement >= 1, "the elements of a patch are divided at least once");
  constexpr double kLawBlendTime = 0.01;  // of the jump between two solutions of a law [s]
  body.law = scene.law, body.viscosity = scene.viscosity;
  if (body.law) body.follow.blend_time = kLawBlendTime;
  body.contacts = scene.contacts;
  body.patch_memory = std::size_t(std::max(scene.memory, kLeastPatchMemory) * 1e9);
  body.follow.hysteresis = scene.patch.hysteresis;
  return body;
}

RestSurface rest_surface(const SfemBody& body) {
  return {body.model.body.mesh.vertices, body.model.surface.triangles};
}

}  // namespace turgor

#include "turgor/geometry/organ_mesh.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/invariants.hpp"
#include "turgor/core/number_text.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/geometry/curve_sides.hpp"
#include "turgor/geometry/labeled_component.hpp"
#include "turgor/geometry/manifold.hpp"
#include "turgor/geometry/quadratic.hpp"
#include "turgor/geometry/stuffing.hpp"
#include "turgor/geometry/surface_check.hpp"

namespace turgor {

namespace {

constexpr double kMostLatticePoints = 2e8;  // 1 GB including the work arrays of stuffing
constexpr double kVolumeTolerance = 0.002;  // tolerance of the level search, relative
constexpr double kVolumeNote = 0.02;        // error that gives a note
constexpr double kCrossingVolume = 0.05;    // volume enclosed twice or not at all
constexpr double kVolumeError = 0.2;        // error that is refused
constexpr double kSmallestSizes = 1.5;      // smallest cube root of a body's volume, in lattice sizes

std::string mm(double meters) { return number_text(meters * 1e3) + " mm"; }
std::string ml(double cubic_meters) { return number_text(cubic_meters * 1e6) + " mL"; }

/// Lattice size with about ten elements across a body of this volume.
double advised_size(double volume) { return std::cbrt(volume) / 8; }

Status check_size(const SignedDistance& shape, double volume, double size) {
  if (!(size > 0) || !std::isfinite(size))
    return Error{"the lattice size is " + mm(size) + "; expected more than 0"};
  const Vec3d extent = shape.high - shape.low;
  const double cells = (extent.x / size + 4) * (extent.y / size + 4) * (extent.z / size + 4);
  if (2 * cells > kMostLatticePoints)
    return Error{"a lattice of " + mm(size) + " over " + mm(extent.x) + " x " + mm(extent.y) + " x " +
                 mm(extent.z) + " has " + number_text(2 * cells) + " points; expected at most " +
                 number_text(kMostLatticePoints) + ". " + mm(advised_size(volume)) +
                 " would suffice. Are the coordinates in meters?"};
  if (std::cbrt(volume) < kSmallestSizes * size)
    return Error{"the body has " + ml(volume) + " (" + mm(extent.x) + " x " + mm(extent.y) + " x " +
                 mm(extent.z) + "): too small for a lattice of " + mm(size) + "; " +
                 mm(advised_size(volume)) + " would suffice"};
  return Done{};
}

/// The time is that of the distances, measured at points across the lattice, and of the elements.
MeshForecast forecast(const Exec& exec, const SignedDistance& shape, const BccLattice& lattice,
                      double volume) {
  constexpr double kElementsPerCube = 12, kSecondsPerElement = 3e-6;  // measured on one core of 2024
  constexpr std::int64_t kMeasured = 500;
  MeshForecast forecast;
  forecast.points = double(point_count(lattice));
  forecast.elements = kElementsPerCube * volume / std::pow(lattice.size, 3);
  const Timer timer;
  const std::int64_t stride = std::max<std::int64_t>(1, point_count(lattice) / kMeasured);
  std::int64_t measured = 0;
  double sum = 0;
  for (std::int64_t id = 0; id < point_count(lattice); id += stride, measured++)
    sum += shape.at(place_of(lattice, point_of(lattice, id)));
  TURGOR_CHECK(std::isfinite(sum), "a distance is finite");
  forecast.seconds = timer.seconds() * forecast.points / double(measured) / exec.threads() +
                     kSecondsPerElement * forecast.elements;
  return forecast;
}

Status check_forecast(const MeshForecast& forecast, const MeshBound& bound, double volume, double size) {
  if (forecast.elements <= bound.elements) return Done{};
  const double coarser = size * std::cbrt(forecast.elements / bound.elements);
  return Error{"a lattice of " + mm(size) + " in " + ml(volume) + " gives about " +
               number_text(forecast.elements) + " tetrahedra; expected at most " +
               number_text(bound.elements) + ", as " + mm(coarser) + " gives. " + mm(advised_size(volume)) +
               " would suffice. Are the coordinates in meters?"};
}

double surface_area(const SolidMesh& mesh) {
  double sum = 0;
  for (const auto [a, b, c] : surface(mesh).triangles) {
    const auto& x = mesh.vertices;
    sum += norm(cross(x[std::size_t(b)] - x[std::size_t(a)], x[std::size_t(c)] - x[std::size_t(a)])) / 2;
  }
  return sum;
}

struct LargestComponent {
  SolidMesh mesh;
  double volume = 0;          // [m³]
  double dropped_volume = 0;  // of the other components [m³]
  int dropped = 0;
};

LargestComponent largest_component(const SolidMesh& mesh) {
  const std::vector<int> component = connected_components(mesh);
  std::vector<std::uint8_t> keep(component.size());
  LargestComponent largest;
  for (std::size_t e = 0; e < component.size(); e++) {
    keep[e] = component[e] == 0;
    (component[e] == 0 ? largest.volume : largest.dropped_volume) += volume(mesh, e);
    largest.dropped = std::max(largest.dropped, component[e]);
  }
  largest.mesh = largest.dropped > 0 ? kept_elements(mesh, keep) : mesh;
  return largest;
}

void curve(const Exec& exec, const SignedDistance& shape, double level, LargestComponent& component) {
  if (component.mesh.elements.empty()) return;
  component.mesh = with_middles(component.mesh);
  curve_sides(exec, component.mesh, [&](Vec3d x) { return shape.at(x) - level; });
  component.volume = volume(component.mesh);
}

/// Stuffs the shape at the level whose mesh has the target volume, because flat triangles cut off round
/// regions and lattices lose thin ones. Newton steps: the derivative of the volume by the level is the
/// surface area.
LargestComponent stuff_volume(const Exec& exec, const LatticeSamples& samples, double target, Sides sides,
                              const Progress& progress) {
  const double farthest = samples.lattice.size / 2;
  LargestComponent best;
  double level = 0;
  for (int pass = 0; pass < 6; pass++) {
    LargestComponent now = largest_component(stuff(exec, samples, level));
    if (sides == Sides::kCurved) curve(exec, samples.shape, level, now);
    if (progress) progress(0.5 + 0.5 * (pass + 1) / 6);
    // Newton step of the level
    const double missing = target - now.volume, area = surface_area(now.mesh);
    if (std::abs(missing) < std::abs(target - best.volume)) best = std::move(now);
    if (std::abs(missing) < kVolumeTolerance * target || !(area > 0)) break;
    level = std::clamp(level + missing / area, -farthest, farthest);
  }
  return best;
}

Status note_result(const LargestComponent& component, double target, double size,
                   std::vector<std::string>& notes) {
  const double off = component.volume / target - 1;
  const std::string advice = "; " + mm(std::min(size / 2, advised_size(target))) + " would resolve it better";
  if (std::abs(off) > kVolumeError)
    return Error{"a lattice of " + mm(size) + " is too coarse for this shape: " + ml(component.volume) +
                 " of its " + ml(target) + " remain" + advice};
  if (std::abs(off) > kVolumeNote)
    notes.push_back("the mesh has " + ml(component.volume) + ", the input " + ml(target) + advice);
  if (component.dropped > 0)
    notes.push_back(std::to_string(component.dropped) +
                    (component.dropped == 1 ? " component" : " components") + " with " +
                    ml(component.dropped_volume) + " separated, too thin for the lattice, and were dropped" +
                    advice);
  return Done{};
}

/// Size with the least number of edges across the body, in two digits, and a note if it is smaller than the
/// given one.
double size_within(const MeshBound& bound, double volume, double size, std::vector<std::string>& notes) {
  if (!(bound.edges > 0) || !(volume > 0)) return size;
  const double across = std::cbrt(volume) / bound.edges;
  const double digit = std::pow(10, std::floor(std::log10(across)) - 1);
  const double largest = std::round(across / digit) * digit;
  if (!(largest < size)) return size;
  notes.push_back("edges of " + mm(largest) + " were chosen for a body of " + ml(volume));
  return largest;
}

Result<OrganMesh> mesh_of_shape(const Exec& exec, SignedDistance shape, double target, double size,
                                std::vector<std::string> notes, Sides sides, const Progress& progress,
                                const MeshBound& bound) {
  if (Status suits = check_size(shape, target, size); !suits) return suits.error();
  const BccLattice lattice = lattice_around(shape, size, size / 2);
  const MeshForecast expected = forecast(exec, shape, lattice, target);
  if (Status fits = check_forecast(expected, bound, target, size); !fits) return fits.error();
  if (bound.begin) bound.begin(expected);
  const LatticeSamples samples = sample(exec, std::move(shape), lattice, [&progress](double done) {
    if (progress) progress(0.5 * done);
  });
  LargestComponent component = stuff_volume(exec, samples, target, sides, progress);
  if (Status noted = note_result(component, target, size, notes); !noted) return noted.error();
  return OrganMesh{std::move(component.mesh), target, std::move(notes)};
}

/// Label at the centroid of every element, or the first one.
std::vector<int> regions_of(const SolidMesh& mesh, const LabelVolume& labels, std::span<const int> chosen) {
  std::vector<int> regions;
  for (std::size_t e = 0; e < element_count(mesh); e++) {
    const Vec3d p = index_at(labels.grid, centroid(mesh, e));
    const Int3 voxel{int(std::lround(p.x)), int(std::lround(p.y)), int(std::lround(p.z))};
    const int label = contains(labels.grid, voxel) ? int(labels.at(voxel.x, voxel.y, voxel.z)) : 0;
    const bool known = std::find(chosen.begin(), chosen.end(), label) != chosen.end();
    regions.push_back(known ? label : chosen[0]);
  }
  return regions;
}

/// Checks that a self-crossing surface still has a single interior. The volume enclosed with its winding
/// number is compared with the volume inside.
Status check_crossings(const Exec& exec, const CheckedSurface& body, const SignedDistance& shape) {
  if (body.crossings == 0 || !(body.volume > 0)) return Done{};
  const BccLattice lattice = lattice_around(shape, std::cbrt(body.volume) / 15, 0);
  const LatticeSamples samples = sample(exec, shape, lattice);
  const auto inside =
      std::count_if(samples.distance.begin(), samples.distance.end(), [](float d) { return d < 0; });
  const double volume = double(inside) * std::pow(lattice.size, 3) / 2;
  if (std::abs(volume / body.volume - 1) < kCrossingVolume) return Done{};
  return Error{body.notes.back() + ", which is " + ml(volume) + ", while its triangles enclose " +
               ml(body.volume) + "; expected a surface with a single interior"};
}

/// Notes cavities and what is in them. Smoothing closes those well below the lattice's edge length.
void note_cavities(const std::vector<EnclosedLabel>& found, bool are_filled, double size,
                   std::vector<std::string>& notes) {
  double sum = 0;
  std::string names;
  for (const EnclosedLabel& enclosed : found) {
    sum += enclosed.volume;
    names += (names.empty() ? "" : ", ") + std::to_string(enclosed.label);
  }
  if (sum < size * size * size / 8) return;
  const std::string where = "where it encloses other labels (" + names + ", " + ml(sum) + ")";
  if (are_filled)
    notes.push_back(
        "the body has its own tissue " + where +
        ": name these labels, too (in scenes by inside), for another tissue, or keep the cavities "
        "(cavities = \"keep\")");
  else
    notes.push_back("the body is hollow " + where);
}

}  // namespace

Result<OrganMesh> mesh_of_surface(const Exec& exec, const TriMesh& surface, double size,
                                  const Progress& progress, Sides sides, const MeshBound& bound) {
  Result<CheckedSurface> body = check_surface(exec, surface);
  if (!body) return body.error();
  SignedDistance shape = distance_to_surface(body->mesh);
  if (Status crossings = check_crossings(exec, *body, shape); !crossings) return crossings.error();
  size = size_within(bound, body->volume, size, body->notes);
  return mesh_of_shape(exec, std::move(shape), body->volume, size, body->notes, sides, progress, bound);
}

Result<OrganMesh> mesh_of_labels(const Exec& exec, const LabelVolume& labels, std::span<const int> chosen,
                                 double size, const Progress& progress, Sides sides, const MeshBound& bound,
                                 const Cavities& cavities) {
  Result<LabeledComponent> component = largest_labeled_component(labels, chosen);
  if (!component) return component.error();
  const std::vector<EnclosedLabel> found = cavities.are_filled
                                               ? fill_cavities(labels, cavities.kept_out, *component)
                                               : enclosed_labels(labels, component->inside);
  size = size_within(bound, component->volume, size, component->notes);
  note_cavities(found, cavities.are_filled, size, component->notes);
  // smooth away the voxel steps, and details below the lattice's resolution
  const Vec3d h = labels.grid.spacing;
  const double smoothing =
      std::max(0.75 * std::max({h.x, h.y, h.z}), (sides == Sides::kCurved ? 0.1 : 0.2) * size);
  Result<OrganMesh> organ =
      mesh_of_shape(exec, distance_to_voxels(exec, labels.grid, component->inside, smoothing),
                    component->volume, size, component->notes, sides, progress, bound);
  if (!organ) return organ.error();
  organ->mesh.regions = regions_of(organ->mesh, labels, chosen);
  return organ;
}

}  // namespace turgor

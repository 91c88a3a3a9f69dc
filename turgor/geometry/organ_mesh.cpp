#include "turgor/geometry/organ_mesh.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/number_text.hpp"
#include "turgor/geometry/curve_sides.hpp"
#include "turgor/geometry/labeled_component.hpp"
#include "turgor/geometry/manifold.hpp"
#include "turgor/geometry/quadratic.hpp"
#include "turgor/geometry/stuffing.hpp"
#include "turgor/geometry/surface_check.hpp"

namespace turgor {

namespace {

constexpr double kMostLatticePoints = 2e8;  // 1 GB with what stuffing needs
constexpr double kVolumeTolerance = 0.002;  // where the search for a level ends
constexpr double kVolumeNote = 0.02;        // what is said
constexpr double kCrossingVolume = 0.05;    // enclosed twice or not at all
constexpr double kVolumeError = 0.2;        // what is refused
constexpr double kSmallestSizes = 1.5;      // a body's cube root of volume, in lattice sizes

std::string mm(double meters) { return number_text(meters * 1e3) + " mm"; }
std::string ml(double cubic_meters) { return number_text(cubic_meters * 1e6) + " mL"; }

/// A size at which a body of this volume has some ten elements across.
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
                 " would do; or are the coordinates not in metres?"};
  if (std::cbrt(volume) < kSmallestSizes * size)
    return Error{"the body has " + ml(volume) + " (" + mm(extent.x) + " x " + mm(extent.y) + " x " +
                 mm(extent.z) + "): too small for a lattice of " + mm(size) + "; " +
                 mm(advised_size(volume)) + " would do"};
  return Done{};
}

double surface_area(const SolidMesh& mesh) {
  double sum = 0;
  for (const auto [a, b, c] : surface(mesh).triangles) {
    const auto& x = mesh.vertices;
    sum += norm(cross(x[std::size_t(b)] - x[std::size_t(a)], x[std::size_t(c)] - x[std::size_t(a)])) / 2;
  }
  return sum;
}

struct LargestPart {
  SolidMesh mesh;
  double volume = 0;          // [m³]
  double dropped_volume = 0;  // of the other parts [m³]
  int dropped = 0;
};

LargestPart largest_part(const SolidMesh& mesh) {
  const std::vector<int> part = connected_parts(mesh);
  std::vector<std::uint8_t> keep(part.size());
  LargestPart largest;
  for (std::size_t e = 0; e < part.size(); e++) {
    keep[e] = part[e] == 0;
    (part[e] == 0 ? largest.volume : largest.dropped_volume) += volume(mesh, e);
    largest.dropped = std::max(largest.dropped, part[e]);
  }
  largest.mesh = largest.dropped > 0 ? kept_elements(mesh, keep) : mesh;
  return largest;
}

void curve(const Exec& exec, const SignedDistance& shape, double level, LargestPart& part) {
  if (part.mesh.elements.empty()) return;
  part.mesh = with_middles(part.mesh);
  curve_sides(exec, part.mesh, [&](Vec3d x) { return shape.at(x) - level; });
  part.volume = volume(part.mesh);
}

/// Stuffs the shape at the level where the mesh has the wanted volume: flat triangles cut off what is round,
/// and lattices what is thin. Newton's steps: a shift of the level changes the volume by the surface's area.
LargestPart stuff_volume(const Exec& exec, const LatticeSamples& samples, double wanted, Sides sides,
                         const Progress& progress) {
  const double farthest = samples.lattice.size / 2;
  LargestPart best;
  double level = 0;
  for (int pass = 0; pass < 6; pass++) {
    LargestPart now = largest_part(stuff(exec, samples, level));
    if (sides == Sides::kCurved) curve(exec, samples.shape, level, now);
    if (progress) progress(0.5 + 0.5 * (pass + 1) / 6);
    const double missing = wanted - now.volume, area = surface_area(now.mesh);
    if (std::abs(missing) < std::abs(wanted - best.volume)) best = std::move(now);
    if (std::abs(missing) < kVolumeTolerance * wanted || !(area > 0)) break;
    level = std::clamp(level + missing / area, -farthest, farthest);
  }
  return best;
}

Status note_result(const LargestPart& part, double wanted, double size, std::vector<std::string>& notes) {
  const double off = part.volume / wanted - 1;
  const std::string advice = "; " + mm(std::min(size / 2, advised_size(wanted))) + " would follow it better";
  if (std::abs(off) > kVolumeError)
    return Error{"a lattice of " + mm(size) + " is too coarse for this shape: " + ml(part.volume) +
                 " of its " + ml(wanted) + " are left" + advice};
  if (std::abs(off) > kVolumeNote)
    notes.push_back("the mesh has " + ml(part.volume) + ", the input " + ml(wanted) + advice);
  if (part.dropped > 0)
    notes.push_back(std::to_string(part.dropped) + (part.dropped == 1 ? " part" : " parts") + " with " +
                    ml(part.dropped_volume) + " came off, too thin for the lattice, and left out" + advice);
  return Done{};
}

Result<OrganMesh> mesh_of_shape(const Exec& exec, SignedDistance shape, double wanted, double size,
                                std::vector<std::string> notes, Sides sides, const Progress& progress) {
  if (Status suits = check_size(shape, wanted, size); !suits) return suits.error();
  const BccLattice lattice = lattice_around(shape, size, size / 2);
  const LatticeSamples samples = sample(exec, std::move(shape), lattice);
  if (progress) progress(0.5);
  LargestPart part = stuff_volume(exec, samples, wanted, sides, progress);
  if (Status noted = note_result(part, wanted, size, notes); !noted) return noted.error();
  return OrganMesh{std::move(part.mesh), wanted, std::move(notes)};
}

/// The label at the centroid of every element, or the first one.
std::vector<int> regions_of(const SolidMesh& mesh, const LabelVolume& labels, std::span<const int> wanted) {
  std::vector<int> regions;
  for (std::size_t e = 0; e < element_count(mesh); e++) {
    const Vec3d p = index_at(labels.grid, centroid(mesh, e));
    const Int3 voxel{int(std::lround(p.x)), int(std::lround(p.y)), int(std::lround(p.z))};
    const int label = contains(labels.grid, voxel) ? int(labels.at(voxel.x, voxel.y, voxel.z)) : 0;
    const bool known = std::find(wanted.begin(), wanted.end(), label) != wanted.end();
    regions.push_back(known ? label : wanted[0]);
  }
  return regions;
}

/// A surface that crosses itself must still have one inside: what it encloses, counted with the times it
/// winds around a place, is compared with what is inside.
Status check_crossings(const Exec& exec, const CheckedSurface& body, const SignedDistance& shape) {
  if (body.crossings == 0 || !(body.volume > 0)) return Done{};
  const BccLattice lattice = lattice_around(shape, std::cbrt(body.volume) / 15, 0);
  const LatticeSamples samples = sample(exec, shape, lattice);
  const auto inside =
      std::count_if(samples.distance.begin(), samples.distance.end(), [](float d) { return d < 0; });
  const double volume = double(inside) * std::pow(lattice.size, 3) / 2;
  if (std::abs(volume / body.volume - 1) < kCrossingVolume) return Done{};
  return Error{body.notes.back() + ", which is " + ml(volume) + ", while its triangles enclose " +
               ml(body.volume) + "; expected a surface with one inside"};
}

}  // namespace

Result<OrganMesh> mesh_of_surface(const Exec& exec, const TriMesh& surface, double size,
                                  const Progress& progress, Sides sides) {
  Result<CheckedSurface> body = check_surface(exec, surface);
  if (!body) return body.error();
  SignedDistance shape = distance_to_surface(body->mesh);
  if (Status crossings = check_crossings(exec, *body, shape); !crossings) return crossings.error();
  return mesh_of_shape(exec, std::move(shape), body->volume, size, body->notes, sides, progress);
}

Result<OrganMesh> mesh_of_labels(const Exec& exec, const LabelVolume& labels, std::span<const int> wanted,
                                 double size, const Progress& progress, Sides sides) {
  Result<LabeledPart> part = largest_labeled_part(labels, wanted);
  if (!part) return part.error();
  // Smooth away the voxels' steps, and details that the lattice could only catch in part.
  const Vec3d h = labels.grid.spacing;
  const double smoothing =
      std::max(0.75 * std::max({h.x, h.y, h.z}), (sides == Sides::kCurved ? 0.1 : 0.2) * size);
  Result<OrganMesh> organ =
      mesh_of_shape(exec, distance_to_voxels(exec, labels.grid, part->inside, smoothing), part->volume, size,
                    part->notes, sides, progress);
  if (organ) organ->mesh.regions = regions_of(organ->mesh, labels, wanted);
  return organ;
}

}  // namespace turgor

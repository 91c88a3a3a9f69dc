// Paints a phantom's shapes row by row, then adds noise.
#include "turgor/geometry/phantom.hpp"

#include <atomic>
#include <cmath>

#include "turgor/core/hash.hpp"
#include "turgor/geometry/phantom_shapes.hpp"

namespace turgor {

namespace {

using phantom::Anatomy;
using phantom::Row;
using phantom::Shape;

/// Work arrays of one row.
struct Painting {
  std::vector<float> hu, distance;
  std::vector<std::uint16_t> label;
};

struct Painter {
  Vec3 first, step;  // position of sample (0, 0, 0) and spacing [mm]
  int count;         // samples in a row
  float edge;        // width of the blurred surface, as in a scanner [mm]

  void paint(const Shape& shape, float y, float z, Painting& to) const {
    const int begin = std::max(0, int(std::ceil((shape.low.x - first.x) / step.x)));
    const int end = std::min(count, int(std::floor((shape.high.x - first.x) / step.x)) + 1);
    if (begin >= end) return;
    shape.distance(Row{first.x + float(begin) * step.x, step.x, y, z, end - begin}, to.distance.data());
    const float* distance = to.distance.data();
    for (const auto [inset, density] : shape.layers)
      for (int i = 0; i < end - begin; i++) {
        const float cover = std::clamp(0.5f - (distance[i] + inset) / edge, 0.0f, 1.0f);
        to.hu[std::size_t(begin + i)] += cover * (density - to.hu[std::size_t(begin + i)]);
      }
    if (shape.label == phantom::kKeepLabel) return;
    for (int i = 0; i < end - begin; i++)
      if (distance[i] <= 0) to.label[std::size_t(begin + i)] = shape.label;
  }
};

/// Sum of four uniform numbers: close to a normal distribution of variance 1.
float noise(std::uint64_t key) {
  key = (key ^ (key >> 30)) * 0xbf58476d1ce4e5b9ull;
  key = (key ^ (key >> 27)) * 0x94d049bb133111ebull;
  key ^= key >> 31;
  const auto sum = float((key & 0xffff) + (key >> 16 & 0xffff) + (key >> 32 & 0xffff) + (key >> 48));
  return (sum / 65535 - 2) * 1.7320508f;
}

void add_noise(const PhantomParams& params, std::size_t first, const Painting& row, std::int16_t* out) {
  const float amount = float(params.noise);
  for (std::size_t i = 0; i < row.hu.size(); i++) {
    const std::uint64_t key = (first + i + 1) * 0x9e3779b97f4a7c15ull + params.seed * 0xd1342543de82ef95ull;
    const float hu = std::nearbyint(row.hu[i] + amount * noise(key));
    out[i] = std::int16_t(std::clamp(hu, -1024.0f, 3071.0f));  // range of CT scanners
  }
}

Anatomy make_anatomy(const PhantomParams& params) {
  switch (params.kind) {
    case PhantomKind::kTorso:
      return phantom::make_torso(params.seed);
    case PhantomKind::kHead:
      return phantom::make_head(params.seed);
    default:
      return phantom::make_leg(params.seed);
  }
}

std::vector<const Shape*> shapes_at(const Anatomy& anatomy, float z) {
  std::vector<const Shape*> found;
  for (const Shape& shape : anatomy)
    if (shape.low.z <= z && z <= shape.high.z) found.push_back(&shape);
  return found;
}

/// Slices [begin, end) into `samples`, and their labels unless `labels` is null.
struct Slices {
  int begin, end;
  std::int16_t* samples;
  std::uint16_t* labels;
};

void paint(const Exec& exec, const PhantomParams& params, const Slices& to, const Progress& progress) {
  const Anatomy anatomy = make_anatomy(params);
  const Grid grid = phantom_grid(params);
  const Vec3 first = Vec3(grid.origin * 1e3), step = Vec3(grid.spacing * 1e3);
  const Painter painter{first, step, grid.size.x, std::max(step.x, std::max(step.y, step.z))};
  std::atomic<int> done{0};
  parallel_for(exec, std::size_t(to.end - to.begin), [&](std::size_t n) {
    const int k = to.begin + int(n);
    const std::size_t width = std::size_t(grid.size.x);
    Painting row{std::vector<float>(width), std::vector<float>(width), std::vector<std::uint16_t>(width)};
    const float z = first.z + float(k) * step.z;
    const std::vector<const Shape*> shapes = shapes_at(anatomy, z);
    for (int j = 0; j < grid.size.y; j++) {
      const float y = first.y + float(j) * step.y;
      std::fill(row.hu.begin(), row.hu.end(), float(kAirHu));
      std::fill(row.label.begin(), row.label.end(), std::uint16_t{0});
      for (const Shape* shape : shapes)
        if (shape->low.y <= y && y <= shape->high.y) painter.paint(*shape, y, z, row);
      const std::size_t at = sample_index(grid, 0, j, int(n));
      add_noise(params, sample_index(grid, 0, j, k), row, to.samples + at);
      if (to.labels) std::copy(row.label.begin(), row.label.end(), to.labels + at);
    }
    if (progress) progress(double(++done) / (to.end - to.begin));
  });
}

}  // namespace

Grid phantom_grid(const PhantomParams& params) {
  Grid grid{.size = params.size, .spacing = params.spacing, .origin = {}, .axes = {}};
  const Vec3d last{params.size.x - 1.0, params.size.y - 1.0, params.size.z - 1.0};
  grid.origin = hadamard(params.spacing, last) * -0.5;
  return grid;
}

std::vector<std::int16_t> make_phantom_slices(const Exec& exec, const PhantomParams& params, int begin,
                                              int end) {
  Grid slab = phantom_grid(params);
  slab.size.z = end - begin;
  std::vector<std::int16_t> samples(sample_count(slab));
  paint(exec, params, {begin, end, samples.data(), nullptr}, {});
  return samples;
}

PhantomParams default_phantom(PhantomKind kind) {
  PhantomParams params{.kind = kind};
  if (kind == PhantomKind::kHead) params.size = {512, 512, 544}, params.spacing = {0.46e-3, 0.46e-3, 0.5e-3};
  if (kind == PhantomKind::kLeg) params.size = {512, 512, 1152}, params.spacing = {0.42e-3, 0.42e-3, 0.8e-3};
  return params;
}

CtVolume make_phantom(const Exec& exec, const PhantomParams& params, LabelVolume* labels,
                      const Progress& progress) {
  const Grid grid = phantom_grid(params);
  CtVolume ct{grid, std::vector<std::int16_t>(sample_count(grid))};
  if (labels) *labels = {grid, std::vector<std::uint16_t>(sample_count(grid))};
  paint(exec, params, {0, grid.size.z, ct.samples.data(), labels ? labels->samples.data() : nullptr},
        progress);
  return ct;
}

}  // namespace turgor

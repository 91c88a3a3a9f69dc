#include "turgor/models/cloth/wind.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace turgor::cloth {

namespace {

constexpr double kPi = 3.14159265358979323846;

/// In [0, 1), the same on every machine.
double next_fraction(std::mt19937_64& random) { return double(random() >> 11) * 0x1p-53; }

Vec3d next_direction(std::mt19937_64& random) {
  const double z = 2 * next_fraction(random) - 1, angle = 2 * kPi * next_fraction(random);
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

/// sin(2π a) to 1e-5: Taylor's polynomial on the half turn around the nearest zero.
Lanes sine_of_turns(Lanes a) {
  constexpr float kRound = 12582912;  // 1.5·2²³: adding it leaves no fraction
  a = a - ((a + kRound) - kRound);    // in [-½, ½]
  const Lanes size = a < 0 ? -a : a;
  const Lanes b = larger(smaller(a, 0.5f - size), size - 0.5f), b2 = b * b;  // sin(π − x) = sin x
  return b * (6.2831853f + b2 * (-41.341702f + b2 * (81.605249f + b2 * (-76.705860f + b2 * 42.058694f))));
}

/// The air's velocity at the vertices of a batch.
Lanes3 air_velocity(const Gusts& gusts, Lanes3 x) {
  Lanes3 u{all_lanes(gusts.mean.x), all_lanes(gusts.mean.y), all_lanes(gusts.mean.z)};
  for (const auto& [number, velocity, phase] : gusts.waves) {
    const Lanes s = sine_of_turns(number.x * x.x + number.y * x.y + number.z * x.z + phase);
    u = u + Lanes3{velocity.x * s, velocity.y * s, velocity.z * s};
  }
  return u;
}

/// ½ ρ A (C_n |u_n| u_n + C_t |u_t| u_t) on a triangle, a third for each corner, times dt.
struct TriangleLoad {
  Vec3 impulse, normal;
  Real across = 0, along = 0;  // minus its derivatives by velocity: normal and tangential
};

TriangleLoad load_of(Vec3 edge1, Vec3 edge2, Vec3 u, Real pressure, Real drag) {
  const Vec3 n = cross(edge1, edge2);
  const Real twice_area = norm(n);
  if (!(twice_area > 0)) return {};
  const Vec3 normal = n / twice_area;
  const Real un = dot(u, normal), speed_n = std::abs(un);
  const Vec3 ut = u - normal * un;
  const Real speed_t = norm(ut), a = pressure * twice_area * speed_n, b = drag * twice_area * speed_t;
  return {normal * (a * un) + ut * b, normal, 2 * a, b};
}

struct BlowChunk {
  std::span<const Int3> triangles;
  const ChunkTriangles& chunks;
  const Vectors &x, &v, &air;
  AirLoad out;
  Real pressure, drag;

  void add(std::size_t vertex, const TriangleLoad& load) const {
    const auto [nx, ny, nz] = load.normal;
    const Real d = load.across - load.along;
    out.impulse.add(vertex, load.impulse);
    out.diagonal.add(vertex, {load.along + d * nx * nx, load.along + d * ny * ny, load.along + d * nz * nz});
    out.off_diagonal.add(vertex, {d * nx * ny, d * nx * nz, d * ny * nz});
  }

  void operator()(std::size_t chunk) const {
    const std::size_t begin = chunk * kChunk, end = std::min(begin + kChunk, x.size());
    for (Vectors* field : {&out.impulse, &out.diagonal, &out.off_diagonal})
      for (std::size_t i = begin; i < end; i++) field->set(i, {});
    for (int n = chunks.begin[chunk]; n < chunks.begin[chunk + 1]; n++) {
      const auto [a, b, c] = triangles[std::size_t(chunks.triangle[std::size_t(n)])];
      const auto i = std::size_t(a), j = std::size_t(b), k = std::size_t(c);
      const Vec3 u = (air[i] + air[j] + air[k] - v[i] - v[j] - v[k]) * (Real(1) / 3);
      const TriangleLoad load = load_of(x[j] - x[i], x[k] - x[i], u, pressure, drag);
      for (const std::size_t corner : {i, j, k})
        if (corner >= begin && corner < end) add(corner, load);
    }
  }
};

}  // namespace

Gusts gusts_at(const Air& air, double time) {
  Gusts gusts{.waves = {}, .mean = Vec3(air.velocity)};
  std::mt19937_64 random(air.seed);
  const std::size_t count = gusts.waves.size();
  const double sigma = air.gusts * norm(air.velocity) * std::sqrt(3.0 / double(count));
  for (std::size_t w = 0; w < count; w++) {
    const double length = air.gust_length * std::pow(0.125, double(w) / double(count - 1));
    const Vec3d number = next_direction(random) / length;
    const Vec3d sideways = cross(number, next_direction(random));
    const double start = next_fraction(random), turns = start - dot(number, air.velocity) * time;
    // Σ over waves of mean |velocity|²/2 is three times the variance of a component.
    gusts.waves[w] = {Vec3(number), Vec3(normalized(sideways) * (sigma * std::sqrt(2.0))),
                      Real(turns - std::floor(turns))};
  }
  return gusts;
}

Vec3 air_velocity(const Gusts& gusts, Vec3 x) {
  const Lanes3 u = air_velocity(gusts, Lanes3{all_lanes(x.x), all_lanes(x.y), all_lanes(x.z)});
  return {u.x[0], u.y[0], u.z[0]};
}

ChunkTriangles triangles_by_chunk(std::span<const Int3> triangles, std::size_t padded_count) {
  std::vector<std::vector<int>> lists((padded_count + kChunk - 1) / kChunk);
  for (std::size_t t = 0; t < triangles.size(); t++)
    for (int corner = 0; corner < 3; corner++) {
      std::vector<int>& list = lists[std::size_t(triangles[t][corner]) / kChunk];
      if (list.empty() || list.back() != int(t)) list.push_back(int(t));
    }
  ChunkTriangles chunks;
  chunks.begin.push_back(0);
  for (const auto& list : lists) {
    chunks.triangle.insert(chunks.triangle.end(), list.begin(), list.end());
    chunks.begin.push_back(int(chunks.triangle.size()));
  }
  chunks.triangle.shrink_to_fit();
  return chunks;
}

void blow(const Exec& exec, const Air& air, double time, double dt, std::span<const Int3> triangles,
          const ChunkTriangles& chunks, const Vectors& x, const Vectors& v, Vectors& scratch, AirLoad out) {
  const Gusts gusts = gusts_at(air, time);
  const bool is_steady = air.gusts == 0 || air.velocity == Vec3d{};
  parallel_for(
      exec, x.size() / std::size_t(kLanes),
      [&](std::size_t batch) {
        const std::size_t i = batch * std::size_t(kLanes);
        if (is_steady)
          store(scratch, i, {all_lanes(gusts.mean.x), all_lanes(gusts.mean.y), all_lanes(gusts.mean.z)});
        else
          store(scratch, i, air_velocity(gusts, load(x, i)));
      },
      64);
  const double quarter = 0.25 * air.density * dt / 3;  // of twice the area
  parallel_for(exec, chunks.begin.size() - 1,
               BlowChunk{triangles, chunks, x, v, scratch, out, Real(quarter * air.pressure),
                         Real(quarter * air.drag)});
}

}  // namespace turgor::cloth

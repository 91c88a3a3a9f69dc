#include "turgor/models/lattice/cutting/rim.hpp"

#include <algorithm>

#include "turgor/core/assert.hpp"
#include "turgor/models/lattice/cutting/drawn_curve.hpp"
#include "turgor/models/lattice/cutting/embed_point.hpp"

namespace turgor::lattice {

namespace {

Vec3d mean_of_points(std::span<const Vec3d> points) {
  Vec3d sum;
  for (const Vec3d p : points) sum += p;
  return sum / double(points.size());
}

std::size_t opposite(std::span<const Vec3d> outline, std::size_t n) { return outline.size() - 1 - n; }

double length_through(std::span<const Vec3d> points) {
  double length = 0;
  for (std::size_t n = 1; n < points.size(); n++) length += norm(points[n] - points[n - 1]);
  return length;
}

}  // namespace

std::vector<Vec3d> rim_points(const BladePath& path, double aside) {
  const Vec3d center = mean_of_points(std::span(path.points).first(path.points.size() - 1));
  std::vector<Vec3d> rim;
  for (std::size_t n = 0; n < path.points.size(); n++) {
    const Vec3d away = path.points[n] - center, inward = path.inward[n];
    rim.push_back(path.points[n] + normalized(away - inward * dot(away, inward)) * aside);
  }
  return rim;
}

BladePath axis_of(const BladePath& outline) {
  BladePath axis;
  axis.depth = outline.depth;
  const Vec3d inward = mean_inward(outline);
  const std::size_t half = outline.points.size() / 2;
  for (std::size_t n = 0; n <= half; n++) {
    axis.points.push_back((outline.points[n] + outline.points[opposite(outline.points, n)]) / 2);
    axis.inward.push_back(inward), axis.depths.push_back(outline.depth);
  }
  return axis;
}

OutlineSize size_of(std::span<const Vec3d> outline) {
  OutlineSize size;
  TURGOR_CHECK(outline.size() % 2 == 1 && outline.size() >= 5, "every point of an outline has an opposite");
  const std::size_t half = outline.size() / 2;
  for (std::size_t n = 0; n <= half; n++)
    size.width = std::max(size.width, norm(outline[opposite(outline, n)] - outline[n]));
  size.length = norm(outline[half] - outline[0]);
  const Vec3d center = mean_of_points(outline.first(outline.size() - 1));
  for (std::size_t n = 1; n < outline.size(); n++)
    size.area += 0.5 * norm(cross(outline[n - 1] - center, outline[n] - center));
  return size;
}

std::vector<Vec3d> points_inside(std::span<const Vec3d> outline) {
  std::vector<Vec3d> points;
  for (std::size_t n = 0; n <= outline.size() / 2; n++)
    for (std::size_t j = 0; j < kPointsAcross; j++) {
      const double t = double(j) / (kPointsAcross - 1);
      points.push_back(outline[n] * (1 - t) + outline[opposite(outline, n)] * t);
    }
  return points;
}

OutlineSize size_along_surface(std::span<const Vec3d> points) {
  TURGOR_CHECK(points.size() % kPointsAcross == 0, "a surface has rows of points");
  const std::size_t rows = points.size() / kPointsAcross;
  std::vector<Vec3d> middle;
  OutlineSize size;
  for (std::size_t n = 0; n < rows; n++) {
    const std::span<const Vec3d> row = points.subspan(n * kPointsAcross, kPointsAcross);
    middle.push_back(row[kPointsAcross / 2]);
    size.width = std::max(size.width, length_through(row));
    if (n == 0) continue;
    const std::span<const Vec3d> before = points.subspan((n - 1) * kPointsAcross, kPointsAcross);
    for (std::size_t j = 1; j < kPointsAcross; j++)
      size.area += 0.5 * (norm(cross(before[j] - before[j - 1], row[j - 1] - before[j - 1])) +
                          norm(cross(before[j] - row[j], row[j - 1] - row[j])));
  }
  size.length = length_through(middle);
  return size;
}

std::vector<Vec3d> EmbeddedPoints::now(const Motion& motion) const {
  std::vector<Vec3d> points;
  for (std::size_t n = 0; n < rest.size(); n++)
    points.push_back(rest[n] + Vec3d(displacement(at[n], motion)));
  return points;
}

std::optional<EmbeddedPoints> embed_all(const Model& model, const Cuts& cuts,
                                        const std::vector<Vec3d>& inside, const std::vector<Vec3d>& rest) {
  TURGOR_CHECK(inside.size() == rest.size(), "every point has a position inside");
  const auto fragments = fragments_of(model, cuts);
  std::vector<std::optional<EmbeddedPoint>> found;
  for (const Vec3d p : inside) found.push_back(embed_point(model, cuts, *fragments, p));
  EmbeddedPoints points{rest, {}};
  const auto count = std::ptrdiff_t(rest.size());
  for (std::ptrdiff_t n = 0; n < count; n++) {
    std::optional<EmbeddedPoint> point;
    for (std::ptrdiff_t by = 0; by < count && !point; by++)
      for (const std::ptrdiff_t other : {n - by, n + by})
        if (other >= 0 && other < count && !point) point = found[std::size_t(other)];
    if (!point) return {};
    points.at.push_back(*point);
  }
  return points;
}

EndHeights heights_at_ends(const Model& model, const State& state, const BladePath& path) {
  const double cell = smallest_spacing(model.anatomy.lattice),
               reach = std::max(size_of(path.points).width / 2, 2 * cell);
  const std::size_t half = path.points.size() / 2;
  const Vec3d length = path.points[half] - path.points[0];
  const auto fragments = fragments_of(model, state.cuts);
  const auto height_beyond = [&](std::size_t end, double sign) {
    // samples on a half disc on the skin beyond the end
    constexpr int kSamples = 6;
    const Vec3d inward = path.inward[end], along = normalized(length - inward * dot(length, inward)) * sign,
                across = cross(inward, along);
    double most = 0;
    for (int i = 0; i <= kSamples; i++)
      for (int j = -kSamples; j <= kSamples; j++) {
        if (i * i + j * j > kSamples * kSamples) continue;
        const double step = reach / kSamples;
        const Vec3d skin = path.points[end] + along * (i * step + 0.2 * cell) + across * (j * step);
        // at the skin; in whole cells, it lies beyond the outermost nodes
        auto at = embed_point(model, state.cuts, *fragments, skin);
        if (!at) at = embed_point(model, state.cuts, *fragments, skin + inward * (0.3 * cell));
        if (at) most = std::max(most, -dot(Vec3d(displacement(*at, state.motion)), inward));
      }
    return most;
  };
  return {height_beyond(0, -1), height_beyond(half, 1)};
}

std::optional<Opening> opening_of(const Model& model, const State& state, const BladePath& path) {
  const double aside = kAsideOfBlade * smallest_spacing(model.anatomy.lattice);
  const auto rim = embed_all(model, state.cuts, rim_points(path, aside), path.points);
  if (!rim) return {};
  Opening opening;
  opening.rim = rim->now(state.motion);
  opening.size = size_of(opening.rim);
  for (std::size_t n = 0; n < opening.rim.size(); n++)
    opening.displacement = std::max(opening.displacement, norm(opening.rim[n] - rim->rest[n]));
  return opening;
}

}  // namespace turgor::lattice

#include "turgor/sim/organs/anderson.hpp"

#include <algorithm>
#include <cmath>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor {

namespace {

constexpr std::size_t kMostChanges = 6;
constexpr double kDependent = 1e-3;  // smaller rests of a change are combinations of newer ones

double product(std::span<const double> a, std::span<const double> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); i++) sum += a[i] * b[i];
  return sum;
}
/// a ← a − s b.
void subtract(double s, std::span<const double> b, std::span<double> a) {
  for (std::size_t i = 0; i < a.size(); i++) a[i] -= s * b[i];
}

}  // namespace

void AndersonMixing::advance(std::span<const double> image, std::span<double> z) {
  TURGOR_CHECK(image.size() == z.size(), "an image has the size of its argument");
  Change now{.residual = {image.begin(), image.end()}, .image = {image.begin(), image.end()}};
  subtract(1, z, now.residual);
  // change since the last argument
  if (!last_.residual.empty()) {
    Change change = now;
    subtract(1, last_.residual, change.residual), subtract(1, last_.image, change.image);
    changes_.insert(changes_.begin(), std::move(change));
    if (changes_.size() > kMostChanges) changes_.pop_back();
  }
  last_ = now;
  // smallest residual: changes orthogonal to each other are subtracted one by one
  std::vector<Change> orthogonal;
  for (Change change : changes_) {
    const double before = product(change.residual, change.residual);
    for (const Change& other : orthogonal) {
      const double s = product(change.residual, other.residual);
      subtract(s, other.residual, change.residual), subtract(s, other.image, change.image);
    }
    const double rest = product(change.residual, change.residual);
    if (!(rest > kDependent * kDependent * before)) continue;
    const double scale = 1 / std::sqrt(rest);
    for (std::vector<double>* values : {&change.residual, &change.image})
      for (double& value : *values) value *= scale;
    subtract(product(now.residual, change.residual), change.image, now.image);
    orthogonal.push_back(std::move(change));
  }
  std::copy(now.image.begin(), now.image.end(), z.begin());
}

}  // namespace turgor

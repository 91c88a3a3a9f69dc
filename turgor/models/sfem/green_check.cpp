// Checks of a store of Green's functions: integrity, and correspondence to the model.
#include <algorithm>
#include <cmath>
#include <random>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/models/sfem/green.hpp"

namespace turgor::sfem {

namespace {

/// ‖K g − e‖ for one column g of Ξ and the unit vector e.
double residual(const BlockMatrix& k, std::span<const double> g, std::size_t unit) {
  double sum = 0;
  for (std::size_t row = 0; row + 1 < k.row_begin.size(); row++) {
    std::array<double, 3> r{};
    for (std::size_t b = k.row_begin[row]; b < k.row_begin[row + 1]; b++)
      for (std::size_t i = 0; i < 9; i++)
        r[i / 3] += k.value[9 * b + i] * g[3 * std::size_t(k.column[b]) + i % 3];
    for (std::size_t i = 0; i < 3; i++) sum += std::pow(r[i] - (3 * row + i == unit ? 1 : 0), 2);
  }
  return std::sqrt(sum);
}

/// The largest difference between a column and what the dense store has of it, in parts of the largest value.
double distance_to_store(const Model& model, std::span<const double> g, std::size_t slot, std::size_t axis) {
  const Green& green = model.green;
  const std::size_t side = 3 * green.nodes.size(), first = (3 * slot + axis) * side;
  double difference = 0, largest = 0;
  for (std::size_t i = 0; i < side; i++) {
    // the check column is a column of K⁻¹
    const auto row = std::size_t(model.free_node[std::size_t(green.nodes[i / 3])]);
    const double stored =
        green.single_values.empty() ? green.double_values[first + i] : double(green.single_values[first + i]);
    const double error = std::abs(stored - g[3 * row + i % 3]);
    difference = std::isfinite(error) ? std::max(difference, error) : INFINITY;
    largest = std::max(largest, std::abs(g[3 * row + i % 3]));
  }
  return difference / largest;
}

Status check_columns(const Model& model, const CheckColumns& check) {
  constexpr double kResidual = 1e-6;
  const double precision = model.params.precision == Precision::kSingle ? 1e-6 : 1e-11;
  const std::size_t n = 3 * model.vertex.size();
  for (std::size_t c = 0; c < 3 * check.vertices.size(); c++) {
    const int v = check.vertices[c / 3];
    const std::span<const double> g(&check.values[c * n], n);
    const auto row = std::size_t(model.free_node[std::size_t(v)]);
    if (const double r = residual(model.stiffness, g, 3 * row + c % 3); !(r < kResidual))
      return Error{"the Green's functions of vertex " + std::to_string(v) +
                   " are not those of this body: K times them differs from a unit force by " +
                   std::to_string(r)};
    // the store agrees with it
    const auto slot = std::size_t(model.green.slot[std::size_t(v)]);
    if (!(distance_to_store(model, g, slot, c % 3) < precision))
      return Error{"the stored Green's functions of vertex " + std::to_string(v) +
                   " differ from their check column"};
  }
  return Done{};
}

Status check_sizes(const Model& model) {
  const Green& green = model.green;
  // values
  const std::size_t side = 3 * green.nodes.size();
  const bool single = model.params.precision == Precision::kSingle;
  const std::size_t found = single ? green.single_values.size() : green.double_values.size();
  if (found != side * side)
    return Error{"the store of Green's functions has " + std::to_string(found) + " values, expected " +
                 std::to_string(side * side)};
  // check columns
  const CheckColumns& check = green.check;
  if (check.vertices.empty() || check.values.size() != 9 * check.vertices.size() * model.vertex.size())
    return Error{"the store of Green's functions has no check columns of this body"};
  for (const int v : check.vertices)
    if (v < 0 || std::size_t(v) >= green.slot.size() || green.slot[std::size_t(v)] < 0)
      return Error{"the store of Green's functions has a check column of vertex " + std::to_string(v) +
                   ", which is not kept"};
  return Done{};
}

}  // namespace

std::uint64_t checksum(const Green& green) {
  const auto hash_store = [](const auto& values, std::uint64_t seed) {
    return hash_long_bytes(values.data(), values.size() * sizeof values[0], seed);
  };
  std::uint64_t hash = hash_store(green.double_values, hash_store(green.single_values, kHashSeed));
  hash = hash_values(std::span<const int>(green.check.vertices), hash);
  return hash_values(std::span<const double>(green.check.values), hash);
}

Status check_green(const Model& model) {
  if (const Status sizes = check_sizes(model); !sizes) return sizes;
  if (const Status columns = check_columns(model, model.green.check); !columns) return columns;
  if (checksum(model.green) != model.green.checksum)
    return Error{"the stored Green's functions are damaged: their checksum is " +
                 hash_text(checksum(model.green)) + ", expected " + hash_text(model.green.checksum)};
  return Done{};
}

Status verify_green(const Model& model, int count, std::uint64_t seed) {
  TURGOR_ASSERT(model.factor.has_value() && count >= 0, "columns are recomputed from the factor");
  std::mt19937_64 random(seed);
  std::vector<int> vertices;
  for (int i = 0; i < count; i++) vertices.push_back(model.green.nodes[random() % model.green.nodes.size()]);
  return check_columns(model, full_columns(model, vertices));
}

}  // namespace turgor::sfem

// Relaxation of stress: a Prony series of up to three pairs. Tissue that is held at a strain relaxes from its
// instantaneous stress to the long-term one:
//
//     σ(t) = σ∞ (1 + Σ pᵢ exp(−t/τᵢ))        pᵢ = gᵢ / (1 − Σ gⱼ)
//
// gᵢ is the share of the instantaneous stress that relaxes with the time τᵢ. Moduli are long-term ones.
#pragma once

#include <array>
#include <cstddef>

namespace turgor {

constexpr int kMostPronyPairs = 3;

struct PronyPair {
  double ratio = 0;   // pᵢ, relative to the long-term stress [1]
  double time = 0.1;  // τᵢ [s]

  bool operator==(const PronyPair&) const = default;
};

/// Pairs of a tissue. The unused ones are last, with ratio 0.
struct Prony {
  std::array<PronyPair, kMostPronyPairs> pairs{};

  bool operator==(const Prony&) const = default;
};

/// Series of one pair.
inline Prony one_pair(double ratio, double time) {
  Prony prony;
  prony.pairs[0] = {ratio, time};
  return prony;
}
/// Number of pairs in use; 0 = elastic.
inline int pair_count(const Prony& prony) {
  int count = 0;
  while (count < kMostPronyPairs && prony.pairs[std::size_t(count)].ratio > 0) count++;
  return count;
}
/// Instantaneous stress over the long-term one, minus 1.
inline double total_ratio(const Prony& prony) {
  double sum = 0;
  for (const PronyPair& pair : prony.pairs) sum += pair.ratio;
  return sum;
}

}  // namespace turgor

// Synthetic CTs with known anatomy: a supine torso, head or leg on a table. Shapes are analytic. Noise
// depends only on the seed and the sample's index, so that the result does not depend on the number of
// threads.
#pragma once

#include <cstdint>

#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"
#include "turgor/geometry/volume.hpp"

namespace turgor {

enum class PhantomKind { kTorso, kHead, kLeg };

struct PhantomParams {
  PhantomKind kind = PhantomKind::kTorso;
  Int3 size{512, 512, 300};                     // samples along i, j, k
  Vec3d spacing{0.78125e-3, 0.78125e-3, 1e-3};  // [m]
  std::uint64_t seed = 1;                       // of noise and of small anatomical variations
  double noise = 12;                            // standard deviation [HU]
};

/// Label of the nodule in the liver; all other labels are TotalSegmentator's (5 = liver).
constexpr std::uint16_t kNoduleLabel = 200;

/// Default size and spacing of a kind.
PhantomParams default_phantom(PhantomKind kind);

/// A CT with axes along the patient's (LPS) and the grid's center at the origin; anatomy outside the grid is
/// cut off. Writes labels on the same grid unless `labels` is null.
CtVolume make_phantom(const Exec& exec, const PhantomParams& params, LabelVolume* labels = nullptr,
                      const Progress& progress = {});
/// Grid of the same CT, and its slices [begin, end).
Grid phantom_grid(const PhantomParams& params);
std::vector<std::int16_t> make_phantom_slices(const Exec& exec, const PhantomParams& params, int begin,
                                              int end);

}  // namespace turgor

// Synthetic CTs with known anatomy, for those who have no data: a torso, a head or a leg, lying on its back
// on a table. Shapes are analytic; noise depends on the seed and the sample's index alone, so that the same
// arguments give the same bits on any number of threads.
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
  std::uint64_t seed = 1;                       // of noise and of small differences of anatomy
  double noise = 12;                            // standard deviation [HU]
};

/// Label of the nodule in the liver; all other labels are TotalSegmentator's (5 = liver).
constexpr std::uint16_t kNoduleLabel = 200;

/// The size and spacing a kind has by default.
PhantomParams default_phantom(PhantomKind kind);

/// A CT, axes along the patient's (LPS), centre of the grid at the origin; what is outside the grid is cut
/// off. Writes labels on the same grid unless `labels` is null.
CtVolume make_phantom(const Exec& exec, const PhantomParams& params, LabelVolume* labels = nullptr,
                      const Progress& progress = {});
/// Of the same: where its samples are, and those of slices [begin, end).
Grid phantom_grid(const PhantomParams& params);
std::vector<std::int16_t> make_phantom_slices(const Exec& exec, const PhantomParams& params, int begin,
                                              int end);

}  // namespace turgor

// Which body: its model, and where it is among those of that model, in a scene as in the world made from it.
#pragma once

#include <cstdint>

namespace turgor {

enum class BodyKind : std::uint8_t { kLattice, kSfem, kRhombus, kCloth };

struct BodyId {
  BodyKind kind = BodyKind::kLattice;
  int index = 0;
  bool operator==(const BodyId&) const = default;
};

/// As in `model = "lattice"`.
constexpr const char* model_name(BodyKind kind) {
  constexpr const char* kNames[] = {"lattice", "sfem", "rhombus", "cloth"};
  return kNames[static_cast<int>(kind)];
}

}  // namespace turgor

#include "app/machine.hpp"

#include <cstring>

namespace turgor {

double copy_bandwidth(const Exec& exec) {
  constexpr std::size_t kPieces = 64, kPiece = std::size_t(4) << 20;
  std::vector<char> from(kPieces * kPiece, 1), to(kPieces * kPiece, 2);
  const double ms = median_ms(7, [&] {
    parallel_for(exec, kPieces,
                 [&](std::size_t p) { std::memcpy(&to[p * kPiece], &from[p * kPiece], kPiece); });
  });
  return 2.0 * kPieces * kPiece / (ms * 1e-3);
}

}  // namespace turgor

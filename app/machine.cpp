#include "app/machine.hpp"

#include <Eigen/Dense>
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

double arithmetic_rate(const Exec& exec) {
  constexpr Eigen::Index kSide = 512;
  const auto threads = std::size_t(exec.threads());
  const Eigen::MatrixXf a = Eigen::MatrixXf::Random(kSide, kSide), b = Eigen::MatrixXf::Random(kSide, kSide);
  std::vector<Eigen::MatrixXf> c(threads, Eigen::MatrixXf::Zero(kSide, kSide));
  const double ms =
      median_ms(9, [&] { parallel_for(exec, threads, [&](std::size_t t) { c[t].noalias() += a * b; }); });
  return 2.0 * double(threads) * kSide * kSide * kSide / (ms * 1e-3);
}

}  // namespace turgor

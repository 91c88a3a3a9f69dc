#include "app/machine.hpp"

#include <Eigen/Dense>
#include <cstring>

namespace turgor {

double copy_bandwidth(const Exec& exec) {
  constexpr std::size_t kBlocks = 64, kBlock = std::size_t(4) << 20;
  std::vector<char> from(kBlocks * kBlock, 1), to(kBlocks * kBlock, 2);
  const double ms = median_ms(7, [&] {
    parallel_for(exec, kBlocks,
                 [&](std::size_t p) { std::memcpy(&to[p * kBlock], &from[p * kBlock], kBlock); });
  });
  return 2.0 * kBlocks * kBlock / (ms * 1e-3);
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

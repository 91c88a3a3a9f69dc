// The processes that share a body, and their collective operations over MPI. Every process calls these in the
// same order. Ranks start at 0 and follow the order of the layers.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "turgor/core/result.hpp"

namespace turgor::mpi {

/// Initializes and finalizes MPI.
struct Ranks {
  int rank = 0, count = 1;

  Ranks(int& argc, char**& argv);
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;
};

/// Aborts all processes when one cannot continue and others may wait for it.
[[noreturn]] void end_all(int exit_code);

std::vector<std::byte> join_bytes(const Ranks& ranks, std::span<const std::byte> owned);
/// Concatenated values of all ranks, in their order.
template <class T>
requires std::is_trivially_copyable_v<T> std::vector<T> join(const Ranks& ranks,
                                                             const std::vector<T>& owned) {
  const std::vector<std::byte> bytes = join_bytes(ranks, std::as_bytes(std::span(owned)));
  std::vector<T> all(bytes.size() / sizeof(T));
  std::copy(bytes.begin(), bytes.end(), std::as_writable_bytes(std::span(all)).begin());
  return all;
}

std::uint32_t largest(std::uint32_t owned);
std::int64_t sum(std::int64_t owned);

/// Sends to one rank and receives from another. Ranks −1 and `count` do not exist: nothing is sent or
/// received.
void pass(const Ranks& ranks, int to, std::span<const std::byte> sent, int from,
          std::span<std::byte> received);

/// A block of memory that is sent to or received from another rank.
struct MessageBlock {
  int rank = 0;
  std::span<std::byte> bytes;
};
/// Sends and receives all blocks; blocks between two ranks are in the same order on both.
void exchange_blocks(const std::vector<MessageBlock>& sent, const std::vector<MessageBlock>& received);

/// Passes a number through all ranks in order; all ranks receive the last result.
std::uint64_t chain(const Ranks& ranks, std::uint64_t first,
                    const std::function<std::uint64_t(std::uint64_t)>& next);

/// The error of the lowest rank that has one, on all ranks.
Status agree(const Ranks& ranks, const Status& owned);

}  // namespace turgor::mpi

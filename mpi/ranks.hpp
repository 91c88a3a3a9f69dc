// The processes that share a body, and what they say to each other: a few shapes of messages over MPI. Every
// process calls these in the same order. Ranks run from 0, in the order of the layers they hold.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "turgor/core/result.hpp"

namespace turgor::mpi {

/// Begins and ends what MPI needs.
struct Ranks {
  int rank = 0, count = 1;

  Ranks(int& argc, char**& argv);
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;
};

/// Ends all processes at once, where one cannot go on and the others may wait for it.
[[noreturn]] void end_all(int exit_code);

std::vector<std::byte> join_bytes(const Ranks& ranks, std::span<const std::byte> owned);
/// Everybody's values, in the order of ranks.
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

/// Sends to one rank and receives as much from another; rank −1 and rank `count` are nobody.
void pass(const Ranks& ranks, int to, std::span<const std::byte> sent, int from,
          std::span<std::byte> received);

/// A piece of a message to or from another rank.
struct Piece {
  int rank = 0;
  std::span<std::byte> bytes;
};
/// All at once; pieces between two ranks are in the same order on both.
void swap_pieces(const std::vector<Piece>& sent, const std::vector<Piece>& received);

/// Continues a number through all ranks in order; everybody gets the last one's.
std::uint64_t chain(const Ranks& ranks, std::uint64_t first,
                    const std::function<std::uint64_t(std::uint64_t)>& next);

/// The error of the lowest rank that has one, on all of them.
Status agree(const Ranks& ranks, const Status& owned);

}  // namespace turgor::mpi

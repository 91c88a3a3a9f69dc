#include "mpi/ranks.hpp"

#include <numeric>

#define OMPI_SKIP_MPICXX 1
#include <mpi.h>

#include "turgor/core/assert.hpp"

namespace turgor::mpi {

Ranks::Ranks(int& argc, char**& argv) {
  int given = 0;  // only the main thread calls MPI
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &given);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &count);
}
Ranks::~Ranks() { MPI_Finalize(); }

void end_all(int exit_code) {
  MPI_Abort(MPI_COMM_WORLD, exit_code);
  std::abort();
}

namespace {

int message_size(std::size_t bytes) {
  TURGOR_ASSERT(bytes < (std::size_t(1) << 31), "a message holds less than 2 GiB");
  return int(bytes);
}

}  // namespace

std::vector<std::byte> join_bytes(const Ranks& ranks, std::span<const std::byte> owned) {
  const int size = message_size(owned.size());
  std::vector<int> sizes(std::size_t(ranks.count)), begin(std::size_t(ranks.count) + 1);
  MPI_Allgather(&size, 1, MPI_INT, sizes.data(), 1, MPI_INT, MPI_COMM_WORLD);
  message_size(std::accumulate(sizes.begin(), sizes.end(), std::size_t(0)));
  std::partial_sum(sizes.begin(), sizes.end(), begin.begin() + 1);
  std::vector<std::byte> all(std::size_t(begin.back()));
  MPI_Allgatherv(owned.data(), size, MPI_BYTE, all.data(), sizes.data(), begin.data(), MPI_BYTE,
                 MPI_COMM_WORLD);
  return all;
}

std::uint32_t largest(std::uint32_t owned) {
  MPI_Allreduce(MPI_IN_PLACE, &owned, 1, MPI_UINT32_T, MPI_MAX, MPI_COMM_WORLD);
  return owned;
}

std::int64_t sum(std::int64_t owned) {
  MPI_Allreduce(MPI_IN_PLACE, &owned, 1, MPI_INT64_T, MPI_SUM, MPI_COMM_WORLD);
  return owned;
}

void pass(const Ranks& ranks, int to, std::span<const std::byte> sent, int from,
          std::span<std::byte> received) {
  const auto rank_or_null = [&](int rank) { return rank >= 0 && rank < ranks.count ? rank : MPI_PROC_NULL; };
  MPI_Sendrecv(sent.data(), message_size(sent.size()), MPI_BYTE, rank_or_null(to), 0, received.data(),
               message_size(received.size()), MPI_BYTE, rank_or_null(from), 0, MPI_COMM_WORLD,
               MPI_STATUS_IGNORE);
}

void exchange_blocks(const std::vector<MessageBlock>& sent, const std::vector<MessageBlock>& received) {
  std::vector<MPI_Request> requests;
  for (const MessageBlock& p : received)
    MPI_Irecv(p.bytes.data(), message_size(p.bytes.size()), MPI_BYTE, p.rank, 1, MPI_COMM_WORLD,
              &requests.emplace_back());
  for (const MessageBlock& p : sent)
    MPI_Isend(p.bytes.data(), message_size(p.bytes.size()), MPI_BYTE, p.rank, 1, MPI_COMM_WORLD,
              &requests.emplace_back());
  MPI_Waitall(int(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
}

std::uint64_t chain(const Ranks& ranks, std::uint64_t first,
                    const std::function<std::uint64_t(std::uint64_t)>& next) {
  if (ranks.rank > 0) MPI_Recv(&first, 1, MPI_UINT64_T, ranks.rank - 1, 2, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
  first = next(first);
  if (ranks.rank + 1 < ranks.count) MPI_Send(&first, 1, MPI_UINT64_T, ranks.rank + 1, 2, MPI_COMM_WORLD);
  MPI_Bcast(&first, 1, MPI_UINT64_T, ranks.count - 1, MPI_COMM_WORLD);
  return first;
}

Status agree(const Ranks& ranks, const Status& owned) {
  const std::string message = owned ? std::string() : owned.error().message + '\0';
  const std::vector<char> all = join(ranks, std::vector<char>(message.begin(), message.end()));
  return all.empty() ? Status(Done{}) : Status(Error{all.data()});
}

}  // namespace turgor::mpi

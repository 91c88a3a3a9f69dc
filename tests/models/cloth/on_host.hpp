// Sheets that step on another side of a bus that is the host, in any order, for tests.
#pragma once

#include <array>
#include <memory>

#include "tests/models/cloth/sheets.hpp"
#include "tests/models/host_side.hpp"
#include "turgor/models/cloth/device/device_sheet.hpp"

namespace turgor::cloth {

#ifdef TURGOR_SAME_BITS
constexpr bool kSameBits = true;
#else
constexpr bool kSameBits = false;  // lanes and threads may fuse other multiplications with additions
#endif

/// As put() does it with a GPU.
template <class R>
std::shared_ptr<SheetBackend> put_on_host(const Model& model) {
  DeviceAllocator<lattice::HostSide<R>> rooms;
  return std::make_shared<DeviceSheet<lattice::HostSide<R>>>(model, rooms);
}
using Put = std::shared_ptr<SheetBackend> (*)(const Model&);

/// Threads, and orders of their own.
inline constexpr std::array<Put, 5> kPuts{
    put_on_host<lattice::ThreadedRun<1>>, put_on_host<lattice::ThreadedRun<2>>,
    put_on_host<lattice::ThreadedRun<8>>, put_on_host<lattice::SeededRun<1>>,
    put_on_host<lattice::SeededRun<2>>};

/// The largest distance of a vertex in one from that in the other.
inline Real apart(const Model& model, const Vectors& a, const Vectors& b) {
  Real most = 0;
  for (std::size_t v = 0; v < std::size_t(model.count); v++) most = std::max(most, norm(a[v] - b[v]));
  return most;
}

}  // namespace turgor::cloth

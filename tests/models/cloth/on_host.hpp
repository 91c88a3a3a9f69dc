// Sheets on a device backend that runs on the host, in any order of the loops.
#pragma once

#include <array>
#include <memory>

#include "tests/models/cloth/sheets.hpp"
#include "tests/models/host_backend.hpp"
#include "turgor/models/cloth/device/device_sheet.hpp"

namespace turgor::cloth {

#ifdef TURGOR_SAME_BITS
constexpr bool kSameBits = true;
#else
constexpr bool kSameBits = false;  // lanes and threads may contract different products
#endif

/// As put() for a GPU.
template <class R>
std::shared_ptr<SheetBackend> put_on_host(const Model& model) {
  DeviceAllocator<lattice::HostBackend<R>> allocator;
  return std::make_shared<DeviceSheet<lattice::HostBackend<R>>>(model, allocator);
}
using Put = std::shared_ptr<SheetBackend> (*)(const Model&);

/// Backends with several threads and shuffled orders.
inline constexpr std::array<Put, 5> kPuts{
    put_on_host<lattice::ThreadedRun<1>>, put_on_host<lattice::ThreadedRun<2>>,
    put_on_host<lattice::ThreadedRun<8>>, put_on_host<lattice::SeededRun<1>>,
    put_on_host<lattice::SeededRun<2>>};

/// Largest distance between the same vertex of two states.
inline Real max_distance(const Model& model, const Vectors& a, const Vectors& b) {
  Real most = 0;
  for (std::size_t v = 0; v < std::size_t(model.count); v++) most = std::max(most, norm(a[v] - b[v]));
  return most;
}

}  // namespace turgor::cloth

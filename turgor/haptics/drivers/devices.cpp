#include "turgor/haptics/drivers/devices.hpp"

#include <utility>

#include <fmt/format.h>

#include "turgor/haptics/drivers/dhd.hpp"
#include "turgor/haptics/drivers/inverse3.hpp"
#include "turgor/haptics/drivers/openhaptics.hpp"
#include "turgor/haptics/drivers/replay.hpp"

namespace turgor::haptics {

namespace {

struct Driver {
  const char *name, *devices;
  std::unique_ptr<Device> (*make)(const DeviceOptions&);
  void (*list)(const DeviceOptions&, DeviceListing&);  // lists connected devices and sets the note
};

template <class T>
std::unique_ptr<Device> make(const DeviceOptions& options) {
  return std::make_unique<T>(options);
}

/// Table of drivers, one row each.
constexpr Driver kDrivers[] = {
    {"inverse3", "Haply Inverse3, Inverse3x, Minverse, with a VerseGrip", make<Inverse3>, list_inverse3},
    {"dhd", "Force Dimension omega, delta, sigma, lambda; Novint Falcon", make<Dhd>, list_dhd},
    {"openhaptics", "3D Systems Touch, Touch X, Phantom", make<OpenHaptics>, list_openhaptics},
    {"replay", "poses from a .csv file, without hardware", make<Replay>, list_replay},
};

}  // namespace

Result<std::unique_ptr<Device>> open_device(const std::string& driver, const DeviceOptions& options) {
  std::string known;
  for (const Driver& d : kDrivers) {
    known += (known.empty() ? "" : ", ") + std::string(d.name);
    if (d.name != driver) continue;
    std::unique_ptr<Device> device = d.make(options);
    if (Status opened = device->open(); !opened) return opened.error();
    return device;
  }
  return Error{fmt::format("expected a driver of haptic devices ({}), found \"{}\"", known, driver)};
}

std::vector<DeviceListing> list_devices(const DeviceOptions& options) {
  std::vector<DeviceListing> listings;
  for (const Driver& d : kDrivers) {
    DeviceListing listing{.driver = d.name, .devices = d.devices};
    d.list(options, listing);
    listings.push_back(std::move(listing));
  }
  return listings;
}

}  // namespace turgor::haptics

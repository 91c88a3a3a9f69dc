#include "turgor/haptics/drivers/devices.hpp"

#include <algorithm>

#include "tests/haptics/drivers/fake_library.hpp"
#include "tests/haptics/drivers/inverse_service.hpp"
#include "tests/haptics/fakes/fake_drd.hpp"
#include "tests/refused.hpp"
#include "turgor/core/timing.hpp"

namespace turgor::haptics {
namespace {

const DeviceListing& of(const std::vector<DeviceListing>& listings, const std::string& driver) {
  for (const DeviceListing& listing : listings)
    if (listing.driver == driver) return listing;
  ADD_FAILURE() << driver << " is not listed";
  return listings.front();
}

// An unknown driver is rejected with a list of the known ones.
TEST(DeviceDrivers, UnknownDriverListsKnown) {
  EXPECT_REFUSED(open_device("omega"), "found \"omega\"", "inverse3", "dhd", "openhaptics", "replay");
}

// Without hardware each driver states within two seconds what it needs, in the fastest of some tries, since
// others may use the machine.
TEST(DeviceDrivers, MissingHardwareIsExplained) {
  std::vector<DeviceListing> listings;
  double fastest = 60;  // [s]
  for (int n = 0; n < 5 && fastest >= 2; n++) {
    const Timer time;
    listings = list_devices({.address = "127.0.0.1:1", .library = "/nowhere/lib.so"});
    fastest = std::min(fastest, time.seconds());
  }
  EXPECT_LT(fastest, 2);
  EXPECT_NE(of(listings, "inverse3").note.find("Haply Inverse Service"), std::string::npos);
  EXPECT_NE(of(listings, "dhd").note.find("install the Force Dimension SDK"), std::string::npos);
  EXPECT_NE(of(listings, "openhaptics").note.find("install 3D Systems OpenHaptics"), std::string::npos);
  for (const DeviceListing& listing : listings) EXPECT_TRUE(listing.connected.empty()) << listing.driver;
}

// Connected devices are listed by names that open them.
TEST(DeviceDrivers, ListedNamesOpenDevices) {
  test::InverseService service;
  service.set_arms({"049D", "04EA"});
  FakeDrd& arm = *test::fake<FakeDrd>(FAKE_DRD, "fake_drd");
  arm = {};
  arm.device_count = 2;
  const DeviceOptions options{.address = service.address(), .library = FAKE_DRD};
  const std::vector<DeviceListing> listings = list_devices(options);
  EXPECT_EQ(of(listings, "inverse3").connected, (std::vector<std::string>{"049D", "04EA"}));
  EXPECT_EQ(of(listings, "dhd").connected, (std::vector<std::string>{"0", "1"}));
  EXPECT_FALSE(arm.is_open);
  EXPECT_EQ(arm.forces_sent, 0);
  DeviceOptions second = options;
  second.which = of(listings, "dhd").connected[1];
  EXPECT_TRUE(open_device("dhd", second));
}

}  // namespace
}  // namespace turgor::haptics

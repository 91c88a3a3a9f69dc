// The component haptics links: a force is clamped to the limit of a device.
#include <cstdio>

#include <turgor/haptics/device.hpp>

int main() {
  turgor::haptics::DeviceSpec spec;
  spec.force = 5;
  const auto output = turgor::haptics::within_limits(spec, {.force = {0, 0, 20}});
  std::printf("%g N\n", output.force.z);
  return output.force.z == 5 ? 0 : 1;
}

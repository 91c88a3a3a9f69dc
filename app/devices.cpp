// `turgor devices`: lists connected haptic devices, and the requirements of the others.
#include "turgor/haptics/drivers/devices.hpp"

#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/commands.hpp"
#include "app/print.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/sim/report/report.hpp"

namespace turgor {

namespace {

using haptics::DeviceListing;

Json describe(const std::vector<DeviceListing>& listings) {
  Json drivers = Json::array();
  for (const DeviceListing& l : listings)
    drivers.push_back(
        {{"driver", l.driver}, {"devices", l.devices}, {"connected", l.connected}, {"note", l.note}});
  return {{"drivers", drivers}};
}

void print_devices(const std::vector<DeviceListing>& listings) {
  print_plain("  {:<12} {:<10} {}\n", "driver", "connected", "devices");
  for (const DeviceListing& l : listings) {
    const std::string connected = l.connected.empty() ? "-" : fmt::format("{}", fmt::join(l.connected, ", "));
    print_plain("  {:<12} {:<10} {}\n  {:<12} {:<10} {}\n", l.driver, connected, l.devices, "", "", l.note);
  }
}

void run_devices(const haptics::DeviceOptions& options, const std::string& json) {
  if (!json.empty()) required(check_file_goal(json));
  const std::vector<DeviceListing> listings = haptics::list_devices(options);
  print_devices(listings);
  if (json.empty()) return;
  const std::string text = json_text(describe(listings), 2) + "\n";
  required(write_file(json, text));
}

}  // namespace

void add_devices_command(CLI::App& program) {
  CLI::App* command = program.add_subcommand(
      "devices", "List haptic devices: connected ones, and requirements of the others");
  auto options = std::make_shared<haptics::DeviceOptions>();
  auto json = std::make_shared<std::string>();
  command->add_option("--address", options->address, "HOST:PORT of the Haply Inverse Service")
      ->capture_default_str();
  command->add_option("--json", *json, "Also write the output to this file");
  command->footer("No device moves. How to connect a device: docs/devices.md\nExample:\n  turgor devices");
  command->callback([options, json] { run_devices(*options, *json); });
}

}  // namespace turgor

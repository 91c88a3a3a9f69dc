// The report of a world, and numbers in it by path.
#include "turgor/sim/report/report.hpp"

#include <nlohmann/json.hpp>

#include "c/buffer.hpp"
#include "c/world.hpp"

namespace turgor::c {

namespace {

Json report_of(const tg_world& world) {
  expect(!world.touched,
         "expected a world without haptic thread, found one between tg_touch_begin and tg_touch_end");
  RunFacts facts;
  facts.warnings = notes_of(*world.world);
  return simulation_report(world.exec, *world.scene, *world.world, world.measures, facts);
}

/// Entry of an object by its key, or of an array of objects by its "name"; null without such an entry.
const Json* entry_of(const Json& value, const std::string& key) {
  if (value.is_object() && value.contains(key)) return &value.at(key);
  if (value.is_array())
    for (const Json& item : value)
      if (item.is_object() && item.contains("name") && item.at("name") == key) return &item;
  return nullptr;
}

const Json& value_at(const Json& report, const std::string& path) {
  const Json* value = &report;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    const std::string key = path.substr(begin, end - begin);
    value = entry_of(*value, key);
    if (!value) throw Refused("expected a number of the report as " + path + ", found no " + key);
    begin = end + 1;
  }
  return *value;
}

/// Appends the numbers of a value, of arrays in their order.
void append_numbers(const Json& value, const std::string& path, std::vector<double>& numbers) {
  if (value.is_number()) return numbers.push_back(value.get<double>());
  if (!value.is_array())
    throw Refused("expected a number or an array of numbers of the report as " + path + ", found " +
                  value.type_name());
  for (const Json& item : value) append_numbers(item, path, numbers);
}

}  // namespace
}  // namespace turgor::c

using namespace turgor;
using namespace turgor::c;

tg_status tg_world_report(tg_world* world, char* buffer, size_t capacity, size_t* count) {
  return with(world, [=](tg_world& w) {
    const std::string text = json_text(report_of(w), -1);
    copy_out(text.c_str(), text.size() + 1, buffer, capacity, count);
  });
}

tg_status tg_world_measure(tg_world* world, const char* path, double* buffer, size_t capacity,
                           size_t* count) {
  return with(world, [=](tg_world& w) {
    expect(path != nullptr, "expected a path, found null");
    std::vector<double> numbers;
    const Json report = report_of(w);
    append_numbers(value_at(report, path), path, numbers);
    copy_out(numbers.data(), numbers.size(), buffer, capacity, count);
  });
}

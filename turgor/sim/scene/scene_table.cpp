#include "turgor/sim/scene/scene_table.hpp"

#include <cmath>
#include <cstdlib>
#include <sstream>

#include "turgor/core/assert.hpp"
#include "turgor/core/plain_text.hpp"
#include "turgor/sim/scene/name.hpp"
#include "turgor/sim/scene/scene_cache.hpp"

namespace turgor {

namespace {

std::string with_unit(const Allowed& allowed) {
  const std::string limits = limits_text(allowed), text = limits.empty() ? "" : " " + limits;
  return *allowed.unit ? fmt::format("{} [{}]", text, allowed.unit) : text;
}

/// True if single precision holds the number, with its full number of digits.
bool fits_single(double value) {
  const double size = std::abs(value);
  return size == 0 ||
         (size >= std::numeric_limits<float>::min() && size <= std::numeric_limits<float>::max());
}

bool allows(const Allowed& allowed, double value) {
  TURGOR_CHECK(allowed.low <= allowed.high, "a range has its lower limit first");
  if (!fits_single(value)) return false;
  return allowed.open ? value > allowed.low && value < allowed.high
                      : value >= allowed.low && value <= allowed.high;
}

/// Reason for refusing a number between 0 and the smallest one of single precision; empty otherwise.
std::string if_too_small(std::optional<double> value) {
  const bool is_small = value && *value != 0 && std::abs(*value) < std::numeric_limits<float>::min();
  return is_small ? ", which is 0 in single precision" : "";
}

/// Hint for a length that was probably given in millimeters; empty otherwise.
std::string if_in_mm(const Allowed& allowed, std::optional<double> value) {
  if (!value || std::abs(*value) < 1 || std::string_view(allowed.unit) != "m" ||
      !allows(allowed, *value / 1000))
    return "";
  return fmt::format(" m; {:g} mm are {:g}", *value, *value / 1000);
}

/// Hint for a length with a unit, such as "4 mm"; empty otherwise. Lengths of a scene are numbers in meters.
std::string if_with_unit(const Allowed& allowed, const toml::node& node) {
  const auto* text = node.as_string();
  if (!text || std::string_view(allowed.unit) != "m") return "";
  char* unit = nullptr;
  const double value = std::strtod(text->get().c_str(), &unit);
  while (*unit == ' ') unit++;
  for (const auto& [name, meters] : {std::pair{"mm", 1e-3}, {"cm", 1e-2}, {"m", 1.0}})
    if (unit != text->get().c_str() && std::string_view(unit) == name && std::isfinite(value))
      return fmt::format("; {:g} {} are {:g}", value, name, value * meters);
  return "";
}

std::string text_of(double value) {
  return std::isfinite(value) ? fmt::format("{}", value) : std::string("none");
}
std::string text_of(const std::string& value) {
  return value.empty() ? "none" : fmt::format("`\"{}\"`", value);
}
template <class T>
std::string text_of(const Vec<T>& v) {
  return fmt::format("`[{}, {}, {}]`", v.x, v.y, v.z);
}

}  // namespace

std::string limits_text(const Allowed& allowed) {
  constexpr double kNone = std::numeric_limits<double>::max();
  const auto text = [](double limit) {
    return std::abs(limit) < 1e10 ? fmt::format("{}", limit) : fmt::format("{:g}", limit);
  };
  if (allowed.low > -kNone && allowed.high < kNone)
    return allowed.open ? fmt::format("between {} and {}", text(allowed.low), text(allowed.high))
                        : fmt::format("from {} to {}", text(allowed.low), text(allowed.high));
  return "";
}

std::string SceneProblems::override_of(const std::string& path) const {
  for (const auto& [key, text] : overrides)
    if (path == key || path.starts_with(key + ".") || path.starts_with(key + "[")) return key;
  return "";
}

std::string SceneProblems::location_of(const std::string& path, const toml::node& node) const {
  if (const std::string key = override_of(path); !key.empty()) return "--set " + key;
  const auto& begin = node.source().begin;
  return begin.line ? fmt::format("{}:{}:{}", file, begin.line, begin.column) : file;
}

void SceneProblems::add(const std::string& path, const toml::node& node, const std::string& what) {
  const std::string location = location_of(path, node);
  const bool in_file = location.starts_with(file);
  const bool is_whole_path = path.empty() || location == "--set " + path;
  const std::string message = is_whole_path ? what : fmt::format("{}: {}", path, what);
  problems.insert(
      {in_file ? node.source().begin.line : 0, on_one_line(fmt::format("{}: {}", location, message))});
}

std::string describe(const toml::node& node, std::size_t longest) {
  if (node.is_table()) return "a table";
  if (const auto* text = node.as_string()) return fmt::format("\"{}\"", text->get().substr(0, 60));
  if (const auto* flag = node.as_boolean()) return flag->get() ? "true" : "false";
  if (const auto* number = node.as_floating_point()) return fmt::format("{}", number->get());
  if (const auto* array = node.as_array()) {
    std::string entries;
    for (const toml::node& entry : *array) {
      entries += (entries.empty() ? "" : ", ") + describe(entry, longest);
      if (entries.size() > longest || entries.find('\n') != std::string::npos) return "an array";
    }
    return "[" + entries + "]";
  }
  std::ostringstream text;
  text << toml::node_view(node);
  return text.str();
}

std::string SceneTable::path_of(std::string_view key) const {
  return path_.empty() ? std::string(key) : fmt::format("{}.{}", path_, key);
}

const toml::node* SceneTable::find(std::string_view key) {
  if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.emplace_back(key);
  return table_.get(key);
}

void SceneTable::fail(std::string_view key, const std::string& what) {
  if (const toml::node* node = table_.get(key))
    problems_.add(path_of(key), *node, what);
  else
    problems_.add(path_, table_, what);
}

void SceneTable::fail_value(std::string_view key, const toml::node& node, const std::string& expected) {
  problems_.add(path_of(key), node, fmt::format("expected {}, found {}", expected, turgor::describe(node)));
}

void SceneTable::fail_name(std::string_view key, const toml::node& node, const std::string& expected,
                           const std::vector<std::string>& names) {
  const auto* text = node.as_string();
  const std::string nearest = text ? nearest_name(text->get(), names) : "";
  const std::string hint = nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest);
  problems_.add(path_of(key), node,
                fmt::format("expected {}, found {}{}", expected, turgor::describe(node), hint));
}

void SceneTable::fail_number(std::string_view key, const toml::node& node, const std::string& expected,
                             const Allowed& allowed) {
  const auto number = node.is_number() ? node.value<double>() : std::nullopt;
  problems_.add(
      path_of(key), node,
      fmt::format("expected {}{}, found {}{}{}{}", expected, with_unit(allowed), turgor::describe(node),
                  if_in_mm(allowed, number), if_with_unit(allowed, node), if_too_small(number)));
}

void SceneTable::read(std::string_view key, double& value, const Allowed& allowed, Meaning meaning) {
  list(key, allowed, text_of(value), meaning);
  const toml::node* node = find(key);
  if (!node) return;
  const auto number = node->is_number() ? node->value<double>() : std::nullopt;
  if (!number || !allows(allowed, *number)) return fail_number(key, *node, "a number", allowed);
  value = *number;
}

void SceneTable::read(std::string_view key, int& value, const Allowed& allowed, Meaning meaning) {
  list(key, allowed, text_of(value), meaning, true);
  const toml::node* node = find(key);
  if (!node) return;
  const auto number = node->is_integer() ? node->value<std::int64_t>() : std::nullopt;
  if (!number || !allows(allowed, double(*number)))
    return fail_value(key, *node, "a whole number" + with_unit(allowed));
  value = int(*number);
}

void SceneTable::read(std::string_view key, bool& value, Meaning meaning) {
  list(key, {}, value ? "true" : "false", meaning);
  const toml::node* node = find(key);
  if (!node) return;
  if (!node->is_boolean()) return fail_value(key, *node, "true or false");
  value = node->as_boolean()->get();
}

void SceneTable::read(std::string_view key, std::string& value, Meaning meaning) {
  list(key, {}, text_of(value), meaning);
  const toml::node* node = find(key);
  if (!node) return;
  if (!node->is_string()) return fail_value(key, *node, "text");
  value = node->as_string()->get();
}

std::vector<double> SceneTable::numbers(std::string_view key, const toml::node& node,
                                        const Allowed& allowed) {
  std::vector<double> values;
  if (!node.is_array()) return fail_number(key, node, "numbers", allowed), values;
  for (const toml::node& element : *node.as_array()) {
    const auto number = element.is_number() ? element.value<double>() : std::nullopt;
    if (!number || !allows(allowed, *number))
      return fail_number(key, element, "numbers", allowed), std::vector<double>{};
    values.push_back(*number);
  }
  return values;
}

void SceneTable::read(std::string_view key, Vec3d& value, const Allowed& allowed, Meaning meaning) {
  list(key, allowed, text_of(value), meaning);
  const toml::node* node = find(key);
  if (!node) return;
  if (!node->is_array() || node->as_array()->size() != 3)
    return fail_value(key, *node, "three numbers" + with_unit(allowed));
  const std::vector<double> v = numbers(key, *node, allowed);
  if (v.size() == 3) value = {v[0], v[1], v[2]};
}

void SceneTable::read(std::string_view key, Int3& value, const Allowed& allowed, Meaning meaning) {
  list(key, allowed, text_of(value), meaning);
  const toml::node* node = find(key);
  if (!node) return;
  const auto* array = node->as_array();
  const bool whole = array && array->size() == 3 && array->is_homogeneous<std::int64_t>();
  if (!whole) return fail_value(key, *node, "three whole numbers" + with_unit(allowed));
  const std::vector<double> v = numbers(key, *node, allowed);
  if (v.size() == 3) value = {int(v[0]), int(v[1]), int(v[2])};
}

void SceneTable::read_path(std::string_view key, std::filesystem::path& value, Meaning meaning) {
  list(key, {}, text_of(value.string()), meaning);
  const toml::node* node = find(key);
  if (!node) return;
  const auto given = problems_.overrides.find(path_of(key));
  const bool overridden = !problems_.override_of(path_of(key)).empty();
  std::string text;
  if (node->is_string())
    text = node->as_string()->get();
  else if (given != problems_.overrides.end())
    text = given->second;  // a folder may be called 2024
  if (text.empty() || text.find('\0') != std::string::npos)
    return fail_value(key, *node, "the name of a file or folder");
  std::error_code ignored;
  const bool is_in_current = problems_.override_folder.empty() || std::filesystem::exists(text, ignored);
  value = (!overridden ? problems_.folder : is_in_current ? "" : problems_.override_folder) / text;
}

void SceneTable::read_cache_folder(std::string_view key, std::filesystem::path& value, Meaning meaning) {
  std::filesystem::path given;
  read_path(key, given, meaning);
  if (given.empty()) return;

  // the command line may choose any folder; the overrides of a recording are another person's
  const std::string path = path_of(key);
  const bool is_recorded = !problems_.override_folder.empty();
  if (!problems_.override_of(path).empty() && !is_recorded) {
    value = given;
    return;
  }

  // a scene or a recording chooses below the user's cache folder
  const toml::node* node = find(key);
  const Result<std::filesystem::path> allowed =
      cache_folder_of_scene(node->is_string() ? std::filesystem::path(node->as_string()->get()) : given);
  if (allowed)
    value = *allowed;
  else if (is_recorded)
    problems_.notes.push_back(on_one_line(
        fmt::format("{}: the recording's folder {} is not below the user's cache folder, which is "
                    "used instead",
                    path, given.string())));
  else
    fail_value(key, *node, allowed.error().message);
}

void SceneTable::read_choice(std::string_view key, std::string& value,
                             const std::vector<std::string>& choices, Meaning meaning) {
  list(key, {}, text_of(value), meaning);
  const toml::node* node = find(key);
  if (!node) return;
  const auto* text = node->as_string();
  if (text && std::find(choices.begin(), choices.end(), text->get()) != choices.end()) {
    value = text->get();
    return;
  }
  fail_name(key, *node, fmt::format("\"{}\"", fmt::join(choices, "\", \"")), choices);
}

void SceneTable::list(std::string_view key, const Allowed& allowed, const std::string& fallback,
                      Meaning meaning, bool is_whole) {
  if (!problems_.lists_keys) return;
  const auto same = [path = path_of(key)](const SceneKey& known) { return known.path == path; };
  if (std::any_of(problems_.keys.begin(), problems_.keys.end(), same)) return;
  const bool is_required = required_.contains(key);
  problems_.keys.push_back({path_of(key), group_, group_path_ + std::string(key), allowed.unit,
                            meaning.fallback ? meaning.fallback
                            : is_required    ? std::string("required")
                                             : fallback,
                            allowed, meaning.text, is_whole});
}

void SceneTable::describe(std::string_view key, const char* unit, const char* fallback, const char* meaning,
                          const Allowed& allowed) {
  Allowed listed = allowed;
  listed.unit = unit;
  list(key, listed, fallback, meaning);
}

SceneTable SceneTable::inner(std::string_view key, std::string_view listed_as) {
  static const toml::table kEmpty;
  const toml::node* node = find(key);
  if (node && !node->is_table()) fail_value(key, *node, "a table");
  const bool found = node && node->is_table();
  SceneTable made(found ? *node->as_table() : kEmpty, path_of(key), problems_);
  made.group_ = group_, made.group_path_ = fmt::format("{}{}.", group_path_, listed_as);
  return made;
}
SceneTable SceneTable::table(std::string_view key) { return inner(key, key); }
SceneTable SceneTable::table_or_text(std::string_view key) {
  static const toml::table kEmpty;
  const toml::node* node = find(key);
  if (!node || !node->is_string()) return inner(key, key);
  SceneTable made(kEmpty, path_of(key), problems_);
  made.group_ = group_, made.group_path_ = fmt::format("{}{}.", group_path_, key);
  return made;
}
std::vector<SceneTable> SceneTable::tables(std::string_view key) {
  static const toml::table kEmpty;
  std::vector<SceneTable> made;
  const auto add = [&](const toml::table& table, std::string path) -> SceneTable& {
    SceneTable& added = made.emplace_back(table, std::move(path), problems_);
    added.group_ = group_, added.group_path_ = fmt::format("{}{}.", group_path_, key);
    return added;
  };
  const toml::node* node = find(key);
  if (!node && problems_.lists_keys) add(kEmpty, path_of(key)).is_listed_ = true;
  if (!node) return made;
  const auto* rows = node->as_array();
  for (std::size_t n = 0; rows && n < rows->size(); n++) {
    const toml::node& row = (*rows)[n];
    if (row.is_table())
      add(*row.as_table(), fmt::format("{}[{}]", path_of(key), n));
    else
      fail_value(key, row, "a table");
  }
  if (!rows) fail_value(key, *node, "an array of tables");
  return made;
}
SceneTable SceneTable::named(std::string_view name) { return inner(name, "NAME"); }

std::vector<std::string> SceneTable::keys() const {
  std::vector<std::pair<toml::source_position, std::string>> found;
  for (const auto& [key, node] : table_) found.emplace_back(key.source().begin, std::string(key.str()));
  std::sort(found.begin(), found.end());
  std::vector<std::string> keys;
  for (auto& [position, key] : found) keys.push_back(std::move(key));
  return keys;
}

std::vector<std::string> SceneTable::names() {
  std::vector<std::string> names = keys();
  for (const std::string& name : names)
    if (!is_name(name)) fail(name, "expected a name of at most 64 letters (a to z, A to Z), digits, _ and -");
  return names;
}

void SceneTable::require(const std::vector<std::string>& keys, const std::string& what_for) {
  if (keys.size() == 1) required_.insert(keys[0]);
  const bool found =
      std::any_of(keys.begin(), keys.end(), [this](const auto& key) { return table_.contains(key); });
  if (!found) missing_.push_back(fmt::format("{} is missing: {}", fmt::join(keys, " or "), what_for));
}

void SceneTable::finish() {
  bool unknown = false;
  for (const auto& [key, node] : table_) {
    if (std::find(known_.begin(), known_.end(), key.str()) != known_.end()) continue;
    const std::string name(key.str());
    const std::string location =
        problems_.override_of(path_of(name)).empty() && key.source().begin.line
            ? fmt::format("{}:{}:{}", problems_.file, key.source().begin.line, key.source().begin.column)
            : problems_.location_of(path_of(name), node);
    const std::string subject =
        location == "--set " + path_of(name) ? location : fmt::format("{}: {}", location, path_of(name));
    problems_.problems.insert(
        {key.source().begin.line,
         on_one_line(fmt::format("{} is not a key of a scene{}", subject, suggestion(name, known_)))});
    unknown = true;
  }
  // a misspelt key explains a missing one
  if (unknown) return;
  for (const std::string& what : missing_) problems_.add(path_, table_, what);
}

}  // namespace turgor

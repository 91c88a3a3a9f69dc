#include "turgor/sim/scene/scene_edit.hpp"

#include <algorithm>
#include <sstream>

#include <fmt/format.h>
#include <toml++/toml.h>

#include "turgor/sim/scene/scene_path.hpp"
#include "turgor/sim/scene/scene_renamed.hpp"

namespace turgor {

namespace {

std::vector<std::string> names_in(const std::string& key) {
  std::vector<std::string> names;
  std::istringstream stream(key);
  for (std::string name; std::getline(stream, name, '.');) names.push_back(name);
  return names;
}

std::string joined(std::span<const std::string> names) {
  std::string key;
  for (const std::string& name : names) key += (key.empty() ? "" : ".") + name;
  return key;
}

/// Value as --set reads it: a bare word is text. File names become absolute.
std::string as_toml(const std::string& value) {
  try {
    if (toml::parse("value = " + value).size() == 1) return value;
  } catch (const toml::parse_error&) {
  }
  std::error_code ignored;
  const bool is_file = std::filesystem::exists(value, ignored);
  return fmt::format("\"{}\"", is_file ? std::filesystem::absolute(value).string() : value);
}

/// Node of a key, or the deepest existing table on its path; `known` = number of names found.
const toml::node* find(const toml::table& root, std::span<const std::string> names, std::size_t& known) {
  const toml::node* node = &root;
  for (known = 0; known < names.size() && node->is_table(); known++) {
    const toml::node* next = find_node(*node->as_table(), names[known]);
    if (!next) break;
    node = next;
  }
  return node;
}

/// Inserts the missing rest of a key into its table.
void insert(std::string& text, const toml::table& table, std::span<const std::string> names,
            std::size_t known, const std::string& value) {
  const std::string line = fmt::format("{} = {}", joined(names.subspan(known)), value);
  const std::size_t begin = table.source().begin ? offset_of(text, table.source().begin) : std::string::npos;
  if (table.is_inline() && begin != std::string::npos) {
    text.insert(begin + 1, fmt::format(" {}{}", line, table.empty() ? " " : ","));
  } else if (known > 0 && begin != std::string::npos && begin < text.size() && text[begin] == '[') {
    const std::size_t end = text.find('\n', begin);
    text.insert(end == std::string::npos ? text.size() : end, "\n" + line);
  } else {
    if (!text.ends_with('\n')) text += '\n';
    text += fmt::format("\n[{}]\n{} = {}\n", joined(names.first(names.size() - 1)), names.back(), value);
  }
}

/// Error: message of the parser.
Result<toml::table> parsed(const std::string& text, const std::filesystem::path& file) {
  try {
    return toml::parse(text, file.string());
  } catch (const toml::parse_error& error) {
    return Error{fmt::format("{}: not TOML: {}", file.string(), error.description())};
  }
}

Status put(std::string& text, const std::filesystem::path& file, const std::string& key,
           const std::string& value) {
  const auto cannot_insert = [&] {
    return Error{fmt::format("{}: {} = {} cannot be inserted into this text; change it by hand",
                             file.string(), key, value)};
  };
  const Result<toml::table> root = parsed(text, file);
  if (!root) return root.error();
  std::vector<std::string> notes;
  const std::vector<std::string> names = names_in(current_key(*root, key, notes));
  if (names.size() < 2 || value.empty()) return cannot_insert();
  std::size_t known = 0;
  const toml::node* node = find(*root, names, known);
  if (known < names.size() && !node->is_table()) return cannot_insert();
  if (known < names.size()) {
    insert(text, *node->as_table(), names, known, value);
  } else {
    const std::size_t begin = offset_of(text, node->source().begin),
                      end = offset_of(text, node->source().end);
    text.replace(begin, end - begin, value);
  }
  const Result<toml::table> again = parsed(text, file);
  if (!again) return cannot_insert();
  find(*again, names, known);
  return known == names.size() ? Status(Done{}) : cannot_insert();
}

}  // namespace

std::string scene_value(const Scene& scene, const std::string& key) {
  // overrides first; the last one wins
  const std::string text = with_current_names(scene.text, scene.file);
  const Result<toml::table> root = parsed(text, scene.file);
  std::vector<std::string> notes;
  for (auto set = scene.overrides.rbegin(); set != scene.overrides.rend(); ++set) {
    const std::size_t equals = std::min(set->find('='), set->size());
    const std::string given = set->substr(0, equals);
    if (equals < set->size() && (root ? current_key(*root, given, notes) : given) == key)
      return set->substr(equals + 1);
  }
  if (!root) return {};

  // else the scene's text
  std::size_t known = 0;
  const std::vector<std::string> names = names_in(key);
  const toml::node* node = find(*root, names, known);
  if (known < names.size() || !node->source().begin) return {};
  const std::size_t begin = offset_of(text, node->source().begin), end = offset_of(text, node->source().end);
  return text.substr(begin, end - begin);
}

Result<std::string> with_values(const std::string& text, const std::filesystem::path& file,
                                const std::vector<std::string>& overrides) {
  std::string changed = with_current_names(text, file);
  for (const std::string& one : overrides) {
    const std::size_t equals = one.find('=');
    if (equals == std::string::npos) return Error{fmt::format("{}: expected key=value", one)};
    const std::string value = one.substr(equals + 1);
    const Status status = put(changed, file, one.substr(0, equals), value.empty() ? value : as_toml(value));
    if (!status) return status.error();
  }
  return changed;
}

namespace {

std::string vector_text(Vec3d x) { return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", x.x, x.y, x.z); }

/// The first free names hand-N.
template <class IsTaken>
std::vector<std::string> hand_names(std::size_t count, const IsTaken& is_taken) {
  std::vector<std::string> names;
  for (int number = 1; names.size() < count; number++)
    if (const std::string name = fmt::format("hand-{}", number); !is_taken(name)) names.push_back(name);
  return names;
}
std::vector<std::string> cut_names(const Scene& scene, std::size_t count) {
  return hand_names(count, [&scene](const std::string& name) {
    return std::any_of(scene.incisions.begin(), scene.incisions.end(),
                       [&name](const IncisionScene& incision) { return incision.blade.name == name; });
  });
}

}  // namespace

std::string incisions_text(const Scene& scene, std::span<const lattice::Incision> cuts) {
  const auto path_text = [](const lattice::Incision& cut) {
    if (cut.path.empty())
      return fmt::format("from = {}\nto = {}\n", vector_text(cut.from), vector_text(cut.to));
    std::string points;
    for (const Vec3d x : cut.path) points += (points.empty() ? "" : ", ") + vector_text(x);
    return fmt::format("path = [{}]\n", points);
  };
  const std::vector<std::string> names = cut_names(scene, cuts.size());
  std::string text;
  for (std::size_t n = 0; n < cuts.size(); n++)
    text += fmt::format("\n[incision.{}]\nbody = \"{}\"\n{}depth = {:.6g}\nstart = 0\nduration = {:.6g}\n",
                        names[n], cuts[n].name, path_text(cuts[n]), cuts[n].depth, cuts[n].duration);
  return text;
}

std::string sutures_text(const Scene& scene, std::span<const lattice::Incision> cuts,
                         std::span<const SavedStitch> stitches) {
  const std::vector<std::string> wounds = cut_names(scene, cuts.size());
  const std::vector<std::string> names = hand_names(stitches.size(), [&scene](const std::string& name) {
    return std::any_of(scene.sutures.begin(), scene.sutures.end(),
                       [&name](const SutureScene& suture) { return suture.name == name; });
  });
  std::string text;
  for (std::size_t n = 0; n < stitches.size(); n++) {
    const SavedStitch& stitch = stitches[n];
    const auto wound = std::size_t(stitch.wound), own = scene.incisions.size();
    std::string points;
    for (const Vec3d x : stitch.through) points += (points.empty() ? "" : ", ") + vector_text(x);
    text += fmt::format("\n[suture.{}]\nwound = \"{}\"\nthrough = [{}]\nthread = \"{}\"\n", names[n],
                        wound < own ? scene.incisions[wound].blade.name : wounds[wound - own], points,
                        stitch.thread);
    if (stitch.tension) text += fmt::format("tension = {:.6g}\n", *stitch.tension);
    text += fmt::format("duration = {:.6g}\n", stitch.duration);
  }
  return text;
}

}  // namespace turgor

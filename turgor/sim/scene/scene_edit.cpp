#include "turgor/sim/scene/scene_edit.hpp"

#include <algorithm>
#include <sstream>

#include <fmt/format.h>
#include <toml++/toml.h>

namespace turgor {

namespace {

std::vector<std::string> parts_of(const std::string& key) {
  std::vector<std::string> parts;
  std::istringstream stream(key);
  for (std::string part; std::getline(stream, part, '.');) parts.push_back(part);
  return parts;
}

std::string joined(std::span<const std::string> parts) {
  std::string key;
  for (const std::string& part : parts) key += (key.empty() ? "" : ".") + part;
  return key;
}

/// As --set understands it: a bare word is text. A file is named from everywhere.
std::string as_toml(const std::string& value) {
  try {
    if (toml::parse("value = " + value).size() == 1) return value;
  } catch (const toml::parse_error&) {
  }
  std::error_code ignored;
  const bool is_file = std::filesystem::exists(value, ignored);
  return fmt::format("\"{}\"", is_file ? std::filesystem::absolute(value).string() : value);
}

std::size_t offset_of(const std::string& text, toml::source_position place) {
  std::size_t at = 0;
  for (toml::source_index line = 1; line < place.line; line++) at = text.find('\n', at) + 1;
  for (toml::source_index column = 1; column < place.column && at < text.size(); column++) {
    at++;
    while (at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0) == 0x80) at++;  // UTF-8
  }
  return at;
}

/// The node that a key leads to, or the deepest table on the way; `known` = parts that were found.
const toml::node* find(const toml::table& root, std::span<const std::string> parts, std::size_t& known) {
  const toml::node* node = &root;
  for (known = 0; known < parts.size() && node->is_table(); known++) {
    const toml::node* next = node->as_table()->get(parts[known]);
    if (!next) break;
    node = next;
  }
  return node;
}

/// Into a table that lacks the rest of a key.
void insert(std::string& text, const toml::table& table, std::span<const std::string> parts,
            std::size_t known, const std::string& value) {
  const std::string line = fmt::format("{} = {}", joined(parts.subspan(known)), value);
  const std::size_t begin = table.source().begin ? offset_of(text, table.source().begin) : std::string::npos;
  if (table.is_inline() && begin != std::string::npos) {
    text.insert(begin + 1, fmt::format(" {}{}", line, table.empty() ? " " : ","));
  } else if (known > 0 && begin != std::string::npos && begin < text.size() && text[begin] == '[') {
    const std::size_t end = text.find('\n', begin);
    text.insert(end == std::string::npos ? text.size() : end, "\n" + line);
  } else {
    if (!text.ends_with('\n')) text += '\n';
    text += fmt::format("\n[{}]\n{} = {}\n", joined(parts.first(parts.size() - 1)), parts.back(), value);
  }
}

/// Error: what the parser says.
Result<toml::table> parsed(const std::string& text, const std::filesystem::path& file) {
  try {
    return toml::parse(text, file.string());
  } catch (const toml::parse_error& error) {
    return Error{fmt::format("{}: not TOML: {}", file.string(), error.description())};
  }
}

Status put(std::string& text, const std::filesystem::path& file, const std::string& key,
           const std::string& value) {
  const auto no_place = [&] {
    return Error{
        fmt::format("{}: {} = {} has no place in this text; change it by hand", file.string(), key, value)};
  };
  const Result<toml::table> root = parsed(text, file);
  if (!root) return root.error();
  const std::vector<std::string> parts = parts_of(key);
  if (parts.size() < 2 || value.empty()) return no_place();
  std::size_t known = 0;
  const toml::node* node = find(*root, parts, known);
  if (known < parts.size() && !node->is_table()) return no_place();
  if (known < parts.size()) {
    insert(text, *node->as_table(), parts, known, value);
  } else {
    const std::size_t begin = offset_of(text, node->source().begin),
                      end = offset_of(text, node->source().end);
    text.replace(begin, end - begin, value);
  }
  const Result<toml::table> again = parsed(text, file);
  if (!again) return no_place();
  find(*again, parts, known);
  return known == parts.size() ? Status(Done{}) : no_place();
}

}  // namespace

std::string scene_value(const Scene& scene, const std::string& key) {
  for (auto set = scene.overrides.rbegin(); set != scene.overrides.rend(); ++set)
    if (set->starts_with(key + "=")) return set->substr(key.size() + 1);
  const Result<toml::table> root = parsed(scene.text, scene.file);
  if (!root) return {};
  std::size_t known = 0;
  const std::vector<std::string> parts = parts_of(key);
  const toml::node* node = find(*root, parts, known);
  if (known < parts.size() || !node->source().begin) return {};
  const std::size_t begin = offset_of(scene.text, node->source().begin),
                    end = offset_of(scene.text, node->source().end);
  return scene.text.substr(begin, end - begin);
}

Result<std::string> with_values(const std::string& text, const std::filesystem::path& file,
                                const std::vector<std::string>& overrides) {
  std::string changed = text;
  for (const std::string& one : overrides) {
    const std::size_t equals = one.find('=');
    if (equals == std::string::npos) return Error{fmt::format("{}: expected key=value", one)};
    const std::string value = one.substr(equals + 1);
    const Status status = put(changed, file, one.substr(0, equals), value.empty() ? value : as_toml(value));
    if (!status) return status.error();
  }
  return changed;
}

std::string incisions_text(const Scene& scene, std::span<const lattice::Incision> cuts) {
  const auto place = [](Vec3d x) { return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", x.x, x.y, x.z); };
  std::string text;
  int number = 1;
  for (const lattice::Incision& cut : cuts) {
    const auto is_taken = [&](const IncisionScene& incision) {
      return incision.blade.name == fmt::format("hand-{}", number);
    };
    while (std::any_of(scene.incisions.begin(), scene.incisions.end(), is_taken)) number++;
    text += fmt::format(
        "\n[incision.hand-{}]\nbody = \"{}\"\nfrom = {}\nto = {}\ndepth = {:.6g}\nstart = 0\nduration = "
        "{:.6g}\n",
        number++, cut.name, place(cut.from), place(cut.to), cut.depth, cut.duration);
  }
  return text;
}

}  // namespace turgor

#include "turgor/sim/scene/scene_renamed.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>

namespace turgor {

namespace {

/// A renamed key. `table` is its dotted table within a body of this model; * stands for any name.
struct RenamedKey {
  const char *model, *table, *before, *now;
};
constexpr RenamedKey kRenamedKeys[] = {
    {"lattice", "", "step", "spacing"},
    {"lattice", "solver", "schedule", "ordering"},
    {"lattice", "solver", "sleep", "sleep_speed"},
    {"sfem", "inclusion.*", "centre", "center"},
    {"sfem", "inclusion.*", "centre_fraction", "center_fraction"},
    {"cloth", "hold.*.ball", "centre", "center"},
    {"cloth", "obstacle.*.sphere", "centre", "center"},
};

/// A renamed value of a key; `key` is the key's current name.
struct RenamedValue {
  const char *model, *table, *key, *before, *now;
};
constexpr RenamedValue kRenamedValues[] = {
    {"lattice", "solver", "method", "descent", "vbd"},
    {"lattice", "solver", "ordering", "colours", "colors"},
    {"lattice", "skin", "law", "fibre", "fiber"},
    {"cloth", "solver", "method", "blocks", "two_level"},
};

constexpr const char* kUntil = "the old name is read until the next release";

std::string key_note(const std::string& table, const RenamedKey& renamed) {
  return fmt::format("{}: key \"{}\" is now \"{}\"; {}", table, renamed.before, renamed.now, kUntil);
}

std::string value_note(const std::string& table, const RenamedValue& renamed) {
  return fmt::format("{}: value \"{}\" of \"{}\" is now \"{}\"; {}", table, renamed.before, renamed.key,
                     renamed.now, kUntil);
}

struct NamedTable {
  toml::table* table;
  std::string path;  // dotted, from the root
};

/// Tables below `from` that match a dotted pattern.
std::vector<NamedTable> matching_tables(const NamedTable& from, std::string_view pattern) {
  std::vector<NamedTable> found{from};
  while (!pattern.empty()) {
    const std::string_view name = pattern.substr(0, pattern.find('.'));
    pattern.remove_prefix(std::min(pattern.size(), name.size() + 1));
    std::vector<NamedTable> next;
    for (const NamedTable& outer : found)
      for (auto&& [key, node] : *outer.table)
        if ((name == "*" || key.str() == name) && node.is_table())
          next.push_back({node.as_table(), fmt::format("{}.{}", outer.path, key.str())});
    found = std::move(next);
  }
  return found;
}

bool matches(std::string_view pattern, std::string_view path) {
  while (!pattern.empty() && !path.empty()) {
    const std::string_view expected = pattern.substr(0, pattern.find('.')),
                           name = path.substr(0, path.find('.'));
    if (expected != "*" && expected != name) return false;
    pattern.remove_prefix(std::min(pattern.size(), expected.size() + 1));
    path.remove_prefix(std::min(path.size(), name.size() + 1));
  }
  return pattern.empty() && path.empty();
}

std::string model_of(const toml::table& body) {
  const toml::node* model = body.get("model");
  return model ? model->value_or(std::string()) : "";
}

std::optional<RenamedUse> rename_key(const NamedTable& in, const RenamedKey& renamed,
                                     SceneProblems& problems) {
  const auto old = in.table->find(renamed.before);
  if (old == in.table->end()) return {};
  const toml::source_region source = old->first.source();
  if (in.table->contains(renamed.now)) {
    problems.add(fmt::format("{}.{}", in.path, renamed.before), old->second,
                 fmt::format("\"{}\" is the old name of \"{}\", and both are given; expected \"{}\" alone",
                             renamed.before, renamed.now, renamed.now));
    in.table->erase(old);
    return {};
  }
  // the node keeps its source region, so that errors still name its line
  in.table->insert(toml::key(renamed.now, source), std::move(old->second));
  in.table->erase(renamed.before);
  return RenamedUse{key_note(in.path, renamed), source, renamed.now};
}

std::optional<RenamedUse> rename_value(const NamedTable& in, const RenamedValue& renamed) {
  toml::node* node = in.table->get(renamed.key);
  if (!node || !node->is_string() || node->as_string()->get() != renamed.before) return {};
  node->as_string()->get() = renamed.now;
  return RenamedUse{value_note(in.path, renamed), node->source(), fmt::format("\"{}\"", renamed.now)};
}

}  // namespace

std::vector<RenamedUse> rename_old_names(toml::table& root, SceneProblems& problems) {
  std::vector<RenamedUse> uses;
  for (const NamedTable& body : matching_tables({&root, ""}, "body.*")) {
    // renamed keys of the body's model
    const std::string model = model_of(*body.table), path = body.path.substr(1);
    for (const RenamedKey& renamed : kRenamedKeys) {
      if (model != renamed.model) continue;
      for (const NamedTable& table : matching_tables({body.table, path}, renamed.table))
        if (std::optional<RenamedUse> use = rename_key(table, renamed, problems))
          uses.push_back(std::move(*use));
    }
    // renamed values of the body's model
    for (const RenamedValue& renamed : kRenamedValues) {
      if (model != renamed.model) continue;
      for (const NamedTable& table : matching_tables({body.table, path}, renamed.table))
        if (std::optional<RenamedUse> use = rename_value(table, renamed)) uses.push_back(std::move(*use));
    }
  }
  return uses;
}

std::string current_key(const toml::table& root, const std::string& key, std::vector<std::string>& notes) {
  // only keys of bodies were renamed
  const std::size_t name_begin = key.find('.') + 1, name_end = key.find('.', name_begin),
                    last = key.rfind('.');
  if (!key.starts_with("body.") || name_end == key.npos) return key;
  const toml::node_view body = root["body"][key.substr(name_begin, name_end - name_begin)];
  if (!body.is_table()) return key;
  // split the key into model, table and subtable
  const std::string model = model_of(*body.as_table()), table = key.substr(0, last);
  const std::string in_body = last > name_end ? key.substr(name_end + 1, last - name_end - 1) : "";
  // replace a renamed key
  for (const RenamedKey& renamed : kRenamedKeys) {
    if (model != renamed.model || key.substr(last + 1) != renamed.before || !matches(renamed.table, in_body))
      continue;
    notes.push_back(key_note(table, renamed));
    return fmt::format("{}.{}", table, renamed.now);
  }
  return key;
}

std::size_t offset_of(std::string_view text, toml::source_position position) {
  std::size_t at = 0;
  for (toml::source_index line = 1; line < position.line; line++) at = text.find('\n', at) + 1;
  for (toml::source_index column = 1; column < position.column && at < text.size(); column++) {
    at++;
    while (at < text.size() && (static_cast<unsigned char>(text[at]) & 0xC0) == 0x80) at++;  // UTF-8
  }
  return at;
}

std::string with_current_names(std::string text, const std::filesystem::path& file) {
  toml::table root;
  try {
    root = toml::parse(text, file.string());
  } catch (const toml::parse_error&) {
    return text;
  }
  SceneProblems ignored;
  std::vector<RenamedUse> uses = rename_old_names(root, ignored);

  // from the end of the text, so that earlier offsets stay valid
  const auto later = [](const RenamedUse& a, const RenamedUse& b) { return b.source.begin < a.source.begin; };
  std::sort(uses.begin(), uses.end(), later);
  for (const RenamedUse& use : uses) {
    const std::size_t begin = offset_of(text, use.source.begin), end = offset_of(text, use.source.end);
    if (use.source.begin && end > begin) text.replace(begin, end - begin, use.replacement);
  }
  return text;
}

}  // namespace turgor

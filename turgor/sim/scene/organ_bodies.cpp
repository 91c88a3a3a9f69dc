#include "turgor/sim/scene/organ_bodies.hpp"

#include <algorithm>
#include <optional>

#include "turgor/sim/scene/name.hpp"

namespace turgor {

namespace {

constexpr const char* kOwnKeys[] = {"bodies", "attachment", "contact"};
constexpr double kTissuePerArea = 1e5;  // between neighbors, unless the table gives it [N/m³]

bool is_own_key(std::string_view key) {
  return std::any_of(std::begin(kOwnKeys), std::end(kOwnKeys), [key](const char* own) { return key == own; });
}

/// Name of the body of a label: the label's own name, or "label-5".
std::string body_name(const toml::node& label) {
  if (const auto text = label.value<std::string>()) return *text;
  if (const auto number = label.value<std::int64_t>()) return fmt::format("label-{}", *number);
  return {};
}

toml::table& table_in(toml::table& parent, const std::string& key) {
  toml::node* node = parent.get(key);
  if (!node || !node->is_table()) node = &parent.insert_or_assign(key, toml::table{}).first->second;
  return *node->as_table();
}

/// Adds what the body's own table does not say.
void add_body(const toml::table& organs, const toml::node& label, const std::string& name,
              toml::table& bodies, SceneProblems& problems) {
  toml::table& body = table_in(bodies, name);
  const auto add = [&body](std::string_view key, const auto& value) {
    if (!body.contains(key)) body.insert(key, value);
  };
  for (const auto& [listed, value] : organs) {
    const std::string key(listed.str());
    if (is_own_key(key) || body.contains(key)) continue;
    value.visit([&](const auto& content) { body.insert(key, content); });
    // an override stays one: its relative path begins at the current folder
    const auto found = problems.overrides.find("organs." + key);
    if (found == problems.overrides.end()) continue;
    const std::string text = found->second;
    problems.overrides[fmt::format("body.{}.{}", name, key)] = text;
  }
  add("model", std::string("sfem"));
  add("fixed", std::string("none"));
  if (const auto text = label.value<std::string>()) add("label", *text);
  if (const auto number = label.value<std::int64_t>()) add("label", *number);
}

/// True if a table of this kind names both bodies.
bool names_pair(const toml::table& tables, const std::string& a, const std::string& b) {
  for (const auto& [key, node] : tables) {
    const toml::table* table = node.as_table();
    const toml::array* between = table ? (*table)["between"].as_array() : nullptr;
    if (!between) continue;
    bool has_a = false, has_b = false;
    for (const toml::node& name : *between) {
      has_a = has_a || name.value_or(std::string()) == a;
      has_b = has_b || name.value_or(std::string()) == b;
    }
    if (has_a && has_b) return true;
  }
  return false;
}

/// Keys of all attachments of the table. None if it says `attachment = "none"`.
std::optional<toml::table> common_attachment(const toml::table& organs, SceneProblems& problems) {
  const toml::node* given = organs.get("attachment");
  if (!given) return toml::table{{"stiffness_per_area", kTissuePerArea}};
  if (given->is_table()) return *given->as_table();
  if (given->value_or(std::string()) != "none")
    problems.add("organs.attachment", *given, "expected a table with the keys of an attachment, or \"none\"");
  return {};
}

/// Keys of all contacts of the table. None if it has no contacts.
std::optional<toml::table> common_contact(const toml::table& organs, SceneProblems& problems) {
  const toml::node* given = organs.get("contact");
  if (given && given->is_table()) return *given->as_table();
  if (given) problems.add("organs.contact", *given, "expected a table with the keys of a contact");
  return {};
}

/// Adds [KIND.A-B] for every pair that has none.
void add_pairs(const std::optional<toml::table>& common, const char* kind,
               const std::vector<std::string>& names, toml::table& root) {
  if (!common) return;
  toml::table& tables = table_in(root, kind);
  for (std::size_t b = 1; b < names.size(); b++)
    for (std::size_t a = 0; a < b; a++) {
      if (names_pair(tables, names[a], names[b])) continue;
      // the later body is tied to, or found against, the earlier one
      toml::table pair = *common;
      pair.insert_or_assign("between", toml::array{names[b], names[a]});
      pair.insert("optional", true);
      tables.insert(names[b] + "-" + names[a], std::move(pair));
    }
}

}  // namespace

void add_organ_bodies(toml::table& root, SceneProblems& problems) {
  const toml::table* organs = root["organs"].as_table();
  if (!organs) return;
  const toml::array* labels = (*organs)["bodies"].as_array();
  std::vector<std::string> names;
  if (labels)
    for (const toml::node& label : *labels) names.push_back(body_name(label));
  // names that cannot be those of bodies
  const bool are_names =
      std::all_of(names.begin(), names.end(), [](const std::string& n) { return is_name(n); });
  if (names.empty() || !are_names) {
    const toml::node* node = organs->get("bodies");
    problems.add("organs.bodies", node ? *node : static_cast<const toml::node&>(*organs),
                 "expected the labels of the bodies, as in bodies = [\"liver\", \"stomach\"]");
    return;
  }
  // bodies, then pairs
  const toml::table copy = *organs;  // the root changes
  toml::table& bodies = table_in(root, "body");
  for (std::size_t n = 0; n < names.size(); n++)
    add_body(copy, *(*copy["bodies"].as_array()).get(n), names[n], bodies, problems);
  add_pairs(common_attachment(copy, problems), "attachment", names, root);
  add_pairs(common_contact(copy, problems), "contact", names, root);
}

void read_organs_table(SceneTable organs) {
  organs.begin_group("organs");
  organs.describe("labels", "", "required", "a segmentation, as for a body with `model = \"sfem\"`");
  organs.describe(
      "bodies", "", "required",
      "labels, each of which becomes a body of that name: names or numbers (`\"label-5\"`). Other keys "
      "of `[body.NAME]` in this table apply to all bodies that do not set them; `fixed` is `\"none\"` by "
      "default");
  organs.describe(
      "attachment", "", "`{ stiffness_per_area = 1e5 }`",
      "a table with the keys of `[attachment.NAME]` except `between`: neighbors are attached where they are "
      "at most `distance` apart, unless the scene has an attachment of the two. `\"none\"`: they are not");
  organs.describe(
      "contact", "", "none",
      "a table with the keys of `[contact.NAME]` except `between`: all pairs of these bodies touch, unless "
      "the scene has a contact of the two");
  for (const std::string& key : organs.keys()) organs.find(key);
  organs.finish();
}

}  // namespace turgor

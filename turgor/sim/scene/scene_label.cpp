#include "turgor/sim/scene/scene_label.hpp"

#include "turgor/sim/scene/label_number.hpp"

namespace turgor {

void read_label(SceneTable& table, const std::string& key, int& label) {
  const toml::node* node = table.find(key);
  if (!node) return;
  const std::string expected = "a label's number (1 to 65535) or an organ's name";
  if (node->is_integer()) return table.read(key, label, within(1, 65535));
  if (!node->is_string()) return table.fail_value(key, *node, expected);
  const std::string name = node->as_string()->get();
  if (const int number = label_number(name); number > 0)
    label = number;
  else
    table.fail(key, fmt::format("expected {}, found \"{}\"{}", expected, name, label_suggestion(name)));
}

}  // namespace turgor

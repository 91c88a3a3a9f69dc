// Label names in a text that accompanies a segmentation.
#include <algorithm>
#include <charconv>
#include <vector>

#include <pugixml.hpp>

#include "turgor/io/volume/volume_header.hpp"

namespace turgor::io {

namespace {

constexpr std::size_t kLongestName = 200;

/// A name for messages: on one line and of limited length.
std::string printable(std::string_view text) {
  std::string name(text.substr(0, kLongestName));
  std::replace_if(
      name.begin(), name.end(), [](char c) { return static_cast<unsigned char>(c) < ' '; }, ' ');
  return name;
}

bool is_label(std::string_view text, int& label) {
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), label);
  return failed == std::errc() && end == text.data() + text.size() && label > 0 && label <= 65535;
}

/// <Label Key="5" …><![CDATA[liver]]></Label>, anywhere in the document.
LabelNames names_in_xml(std::string_view text) {
  LabelNames names;
  pugi::xml_document document;
  document.load_buffer(text.data(), text.size());  // content before a syntax error is still parsed
  for (const pugi::xpath_node found : document.select_nodes("//Label")) {
    int label = 0;
    const std::string name = printable(found.node().child_value());
    if (is_label(found.node().attribute("Key").value(), label) && !name.empty()) names.emplace(label, name);
  }
  return names;
}

/// Quoted and bare words, in the order of the text.
std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  for (std::size_t at = 0; (at = text.find_first_not_of(" \t\r\n{}[],:", at)) < text.size();) {
    const bool is_quoted = text[at] == '"' || text[at] == '\'';
    const std::size_t begin = is_quoted ? at + 1 : at;
    const std::size_t end = std::min(
        is_quoted ? text.find(text[at], begin) : text.find_first_of(" \t\r\n{}[],:", begin), text.size());
    words.push_back(text.substr(begin, end - begin));
    at = end + (is_quoted ? 1 : 0);
  }
  return words;
}

/// {"5": "liver", …} or {"liver": 5, …}.
LabelNames names_in_pairs(std::string_view text) {
  LabelNames names;
  const std::vector<std::string_view> words = words_of(text);
  for (std::size_t i = 0; i + 1 < words.size(); i++) {
    int first = 0, second = 0;
    const bool starts = is_label(words[i], first), ends = is_label(words[i + 1], second);
    if (starts == ends) continue;
    names.emplace(starts ? first : second, printable(words[starts ? i + 1 : i]));
    i++;
  }
  return names;
}

}  // namespace

LabelNames label_names_in(std::string_view text) {
  text = text.substr(0, text.find('\0'));
  const std::size_t start = text.find_first_not_of(" \t\r\n");
  if (start == text.npos) return {};
  if (text[start] == '<') return names_in_xml(text);
  return text[start] == '{' ? names_in_pairs(text) : LabelNames{};
}

}  // namespace turgor::io

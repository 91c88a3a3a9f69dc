#include "turgor/io/files/xml_text.hpp"

#include "turgor/core/plain_text.hpp"

namespace turgor {

namespace {

std::string_view entity(char c) {
  switch (c) {
    case '&':
      return "&amp;";
    case '<':
      return "&lt;";
    case '>':
      return "&gt;";
    case '"':
      return "&quot;";
    case '\'':
      return "&#39;";
    default:
      return {};
  }
}

}  // namespace

std::string xml_text(std::string_view text) {
  std::string escaped;
  for (const char c : plain_text(text)) {
    const std::string_view meant = entity(c);
    if (meant.empty())
      escaped += c;
    else
      escaped += meant;
  }
  return escaped;
}

}  // namespace turgor

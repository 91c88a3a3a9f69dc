#include "turgor/sim/report/summary.hpp"

#include <fmt/format.h>

#include "turgor/sim/report/amount.hpp"
#include "turgor/sim/report/section.hpp"

namespace turgor {

namespace {

/// Width of a UTF-8 text in a terminal.
std::size_t width(const std::string& text) {
  return std::size_t(std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

std::string row(const std::string& what, const std::string& value) {
  constexpr std::size_t kColumn = 34;
  return fmt::format("  {}{:{}}{}\n", what, "", std::max(kColumn, width(what) + 2) - width(what), value);
}

std::string item_text(const Section& section, const Json& item) {
  std::string rows;
  for (const Caption& caption : section.captions) {
    const Json* value = find(item, caption.key);
    if ((caption.shown_in & kInSummary) && value && !value->is_null())
      rows += row(caption.label, amount(*value, caption.unit));
  }
  if (rows.empty()) return "";
  return item.value("name", std::string(section.item)) + "\n" + rows;
}

}  // namespace

std::string summary_text(const Json& report, const std::filesystem::path& folder) {
  std::string text;
  for (const Json& sentence : report.value("verdict", Json::array()))
    text += sentence.get<std::string>() + "\n";
  for (const Section& section : report_sections())
    for (const Json& item : section.items(report)) text += item_text(section, item);
  for (const Json& warning : report.at("warnings"))
    text += fmt::format("warning: {}\n", warning.get<std::string>());
  text += fmt::format("pictures and files   {}\nreport               {}\n", folder.string(),
                      (folder / "report.html").string());
  // the command names the recording as seen from its folder
  std::string more = report.value("more_pictures", std::string());
  const std::string recording = "recording.h5";
  if (const std::size_t at = more.find(recording); at != std::string::npos)
    more.replace(at, recording.size(), (folder / recording).string());
  return more.empty() ? text : text + fmt::format("more pictures        {}\n", more);
}

}  // namespace turgor

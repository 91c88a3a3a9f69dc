// Words of reports: each is a term of docs/glossary.md or plain English.
#include <algorithm>
#include <cctype>
#include <cstring>
#include <fstream>
#include <regex>
#include <set>

#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "turgor/sim/report/section.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
const fs::path kSources = TURGOR_SOURCE_DIR;

/// Words in lower case.
std::set<std::string> words_of(const std::string& text) {
  static const std::regex word("[A-Za-z]+");
  std::set<std::string> words;
  for (auto at = std::sregex_iterator(text.begin(), text.end(), word); at != std::sregex_iterator(); ++at) {
    std::string one = at->str();
    std::transform(one.begin(), one.end(), one.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    words.insert(one);
  }
  return words;
}

/// True for a word, its plural and its possessive.
bool is_known(const std::set<std::string>& known, const std::string& word) {
  if (known.contains(word)) return true;
  for (const auto& [end, by] : {std::pair{"s", ""}, {"es", ""}, {"ies", "y"}})
    if (word.ends_with(end) && known.contains(word.substr(0, word.size() - std::strlen(end)) + by))
      return true;
  return false;
}

/// Terms in the first column of the glossary's tables, and the plain words.
std::set<std::string> known_words() {
  std::string terms = test::bytes_of(kSources / "tests/sim/report/plain_words.txt");
  std::ifstream glossary(kSources / "docs/glossary.md");
  for (std::string line; std::getline(glossary, line) && line != "## Old names";)
    if (line.starts_with("| ")) terms += " " + line.substr(2, line.find(" |", 2));
  return words_of(terms);
}

/// Captions of all tables and key figures.
std::vector<std::string> captions_of_sections() {
  std::vector<std::string> captions;
  for (const Section& section : report_sections()) {
    captions.insert(captions.end(), {section.heading, section.item});
    for (const Caption& caption : section.captions)
      if (caption.shown_in != kInReport || !caption.figure.empty())
        captions.insert(captions.end(), {caption.label, caption.figure});
  }
  return captions;
}

/// Titles and axes of all plots of the page, and names of curves, from the sources.
std::vector<std::string> texts_of_plots() {
  static const std::regex plot(R"re(\w+\{\s*"([^"]*)",\s*"([^"]*)",\s*"([^"]*)",)re");
  std::vector<std::string> texts;
  for (const char* folder : {"turgor/sim/report", "turgor/sim/live"})
    for (const auto& file : fs::directory_iterator(kSources / folder)) {
      const std::string code = test::bytes_of(file.path());
      for (auto at = std::sregex_iterator(code.begin(), code.end(), plot); at != std::sregex_iterator(); ++at)
        for (int group : {1, 2, 3}) texts.push_back((*at)[group]);
    }
  return texts;
}

// Captions, key figures, titles and axes have no word that the glossary lacks, apart from plain English.
TEST(ReportWords, AreInGlossaryOrPlain) {
  const std::set<std::string> known = known_words();
  std::vector<std::string> texts = captions_of_sections();
  EXPECT_GT(texts.size(), 300u);
  const std::vector<std::string> plots = texts_of_plots();
  EXPECT_GT(plots.size(), 40u);
  texts.insert(texts.end(), plots.begin(), plots.end());
  for (const std::string& text : texts)
    for (const std::string& word : words_of(text)) EXPECT_TRUE(is_known(known, word)) << word << ": " << text;
}

}  // namespace
}  // namespace turgor

// Applies docs/adding-a-model.md to a copy of turgor/sim. Blocks under the name of a file become that file;
// blocks of lines with - and + change it. Fails if the page does not fit the tree.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

namespace fs = std::filesystem;

namespace {

struct Block {
  std::string file, language, text;
};

/// Blocks that directly follow a line with the name of a file, such as `path`:
std::vector<Block> blocks_of(const fs::path& page) {
  std::ifstream stream(page);
  std::vector<Block> blocks;
  std::string named;
  bool inside = false;
  for (std::string line; std::getline(stream, line);) {
    if (inside && line == "```") {
      inside = false, named.clear();
    } else if (inside) {
      blocks.back().text += line + "\n";
    } else if (line.rfind("```", 0) == 0 && !named.empty()) {
      blocks.push_back({named, line.substr(3), ""}), inside = true;
    } else if (line.size() > 3 && line.front() == '`' && line.substr(line.size() - 2) == "`:") {
      named = line.substr(1, line.size() - 3);
    }
  }
  return blocks;
}

std::string read(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void write(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream(file) << text;
}

/// One change: the lines before and after it.
struct Change {
  std::string before, after;
};
std::vector<Change> changes_of(const std::string& text) {
  std::vector<Change> changes(1);
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    if (line.empty()) {
      changes.emplace_back();
      continue;
    }
    if (line[0] != '+') changes.back().before += line.substr(1) + "\n";
    if (line[0] != '-') changes.back().after += line.substr(1) + "\n";
  }
  return changes;
}

/// Replaces the lines of a change in a text. False unless the lines occur exactly once.
bool apply(const Change& change, const std::string& name, std::string& text) {
  const std::string lines = "\n" + change.before;
  const std::size_t at = ("\n" + text).find(lines);
  const bool once = at != std::string::npos && ("\n" + text).find(lines, at + 1) == std::string::npos;
  if (once)
    text.replace(at, change.before.size(), change.after);
  else
    std::fprintf(stderr, "%s: expected exactly once in this file:\n%s", name.c_str(), change.before.c_str());
  return once;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return std::fprintf(stderr, "follow_page PAGE SOURCES TREE\n"), 2;
  const fs::path sources = argv[2], tree = argv[3];
  fs::remove_all(tree);
  fs::create_directories(tree / "turgor");
  fs::copy(sources / "turgor/sim", tree / "turgor/sim", fs::copy_options::recursive);
  int files = 0, changed = 0;
  for (const Block& block : blocks_of(argv[1])) {
    if (block.language != "diff") {
      write(tree / block.file, block.text), files++;
      continue;
    }
    std::string text = read(tree / block.file);
    for (const Change& change : changes_of(block.text))
      if (!apply(change, block.file, text)) return 1;
    write(tree / block.file, text), changed++;
  }
  if (files < 5 || changed < 3)
    return std::fprintf(stderr, "expected at least 5 files and 3 changes on the page\n"), 1;
  return 0;
}

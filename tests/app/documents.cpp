// Commands of the documents. Runs are checked on generated inputs; every option of the other commands must
// exist.
#include <regex>

#include "tests/app/program.hpp"

namespace turgor {
namespace {

using test::Ended, test::fresh_folder, test::run_program, test::run_shell;
namespace fs = std::filesystem;

struct Command {
  std::string where, arguments;  // without the program's name
};

/// Lines of documents that begin with the program's name, and the commands in the opening comments of scenes.
std::vector<Command> commands_in(const fs::path& file) {
  static const std::regex line_of_shell(
      R"(^\s*(?:#.*: |# )?(?:build/release/)?turgor ([a-z][^#`]*?)\s*(?:#.*)?$)");
  std::vector<Command> commands;
  std::ifstream text(file);
  int number = 0;
  for (std::string line; std::getline(text, line);) {
    number++;
    std::smatch match;
    if (std::regex_match(line, match, line_of_shell))
      commands.push_back({file.filename().string() + ":" + std::to_string(number), match[1]});
  }
  return commands;
}

std::vector<Command> all_commands() {
  const fs::path root = TURGOR_SOURCE_DIR;
  std::vector<fs::path> files{root / "README.md"};
  for (const char* folder : {"docs", "scenes"})
    for (const auto& entry : fs::recursive_directory_iterator(root / folder))
      if (entry.path().extension() == ".md" || entry.path().extension() == ".toml")
        files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<Command> commands;
  for (const fs::path& file : files)
    for (Command& command : commands_in(file)) commands.push_back(std::move(command));
  return commands;
}

/// A folder with the scenes and the files that a reader would supply.
fs::path folder_of_a_reader() {
  const fs::path folder = fresh_folder();
  fs::copy(fs::path(TURGOR_SOURCE_DIR) / "scenes", folder / "scenes", fs::copy_options::recursive);
  const Ended made = run_program(
      "phantom torso --size 64 48 40 --spacing 6.5 6.5 6.5 -o patient --labels seg.nii.gz && '" TURGOR_PROGRAM
      "' phantom torso --size 64 48 40 --spacing 6.5 6.5 6.5 -o patient.nii.gz && '" TURGOR_PROGRAM
      "' phantom liver --detail 0.3 -o own.obj"
      " && printf 'time_s,x_m,y_m,z_m\\n0,0,0,0\\n1,0,0,0.001\\n' > poses.csv",
      folder);
  EXPECT_EQ(made.code, 0) << made.printed;
  return folder;
}

std::string replaced(std::string text, const std::string& name, const std::string& by) {
  for (std::size_t at = 0; (at = text.find(name, at)) != text.npos; at += by.size())
    text.replace(at, name.size(), by);
  return text;
}

/// Replaces the placeholders of the documents by the reader's files.
std::string with_inputs(std::string arguments) {
  for (const auto& [name, by] : {std::pair{"SEGMENTATION.nii.gz", "seg.nii.gz"},
                                 {"SEG.nii.gz", "seg.nii.gz"},
                                 {"PATIENT.nii.gz", "patient.nii.gz"},
                                 {"FOLDER", "patient"},
                                 {"liver.obj", "own.obj"},
                                 {"FILE.obj", "scenes/tshirt.obj"},
                                 {"scale=0.001", "scale=1"}})
    arguments = replaced(std::move(arguments), name, by);
  return arguments;
}

// Every run in the documents and scenes is accepted by --check.
TEST(Documents, EveryRunPassesCheck) {
  const fs::path folder = folder_of_a_reader();
  std::set<std::string> done;
  for (const Command& command : all_commands()) {
    if (!command.arguments.starts_with("run ") || command.arguments.find("--replay") != std::string::npos)
      continue;
    const std::string arguments = with_inputs(command.arguments) + " --check";
    if (!done.insert(arguments).second) continue;
    const Ended ended = run_program(arguments, folder);
    EXPECT_EQ(ended.code, 0) << command.where << ": turgor " << command.arguments << "\n" << ended.printed;
  }
  EXPECT_GT(done.size(), 12u);
}

// Every option in the documents and scenes appears in the help of its command.
TEST(Documents, EveryOptionExists) {
  const fs::path folder = fresh_folder();
  static const std::regex option(R"(--[a-z][a-z-]*)");
  int seen = 0;
  for (const Command& command : all_commands()) {
    const std::string name = command.arguments.substr(0, command.arguments.find(' '));
    const std::string help = run_program(name + " --help-all", folder).printed;
    ASSERT_NE(help.find("Usage: turgor " + name), std::string::npos) << command.where << ": turgor " << name;
    for (auto at = std::sregex_iterator(command.arguments.begin(), command.arguments.end(), option);
         at != std::sregex_iterator(); ++at, seen++)
      EXPECT_NE(help.find(at->str()), std::string::npos) << command.where << ": turgor " << command.arguments;
  }
  EXPECT_GT(seen, 15);
}

}  // namespace
}  // namespace turgor

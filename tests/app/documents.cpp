// Commands of the documents. Runs are checked on generated inputs; every option of the other commands must
// exist.
#include <regex>

#include "tests/app/program.hpp"

namespace turgor {
namespace {

using test::Ended, test::fresh_folder, test::report_in, test::run_program, test::run_shell, test::write;
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

/// The first block of a page that begins with this mark, without the marks of code.
std::string first_block(const fs::path& page, const std::string& mark, const std::string& heading = "") {
  const std::string text = test::bytes_of(page);
  const std::size_t begin = text.find(mark, text.find(heading));
  EXPECT_NE(begin, text.npos) << page << ": no block after '" << heading << "'";
  const std::size_t first = begin + mark.size();
  return text.substr(first, text.find("```", first) - first);
}

/// A block of TOML on a page.
struct TomlBlock {
  std::string where, text;
};

std::vector<TomlBlock> toml_blocks() {
  const fs::path root = TURGOR_SOURCE_DIR;
  std::vector<fs::path> pages{root / "README.md"};
  for (const auto& entry : fs::recursive_directory_iterator(root / "docs"))
    if (entry.path().extension() == ".md") pages.push_back(entry.path());
  std::sort(pages.begin(), pages.end());
  const std::string mark = "\n```toml\n";
  std::vector<TomlBlock> blocks;
  for (const fs::path& page : pages) {
    const std::string text = test::bytes_of(page);
    for (std::size_t at = 0; (at = text.find(mark, at)) != text.npos;) {
      at += mark.size();
      blocks.push_back(
          {page.filename().string() + ":" +
               std::to_string(2 + std::count(text.begin(), text.begin() + std::ptrdiff_t(at), '\n') - 1),
           text.substr(at, text.find("\n```", at) + 1 - at)});
    }
  }
  return blocks;
}

/// Tables that a page leaves to its reader, by the line with which a block of the page begins.
std::string left_to_reader(const std::string& block) {
  const auto organ = [](const std::string& name) {
    return "[body." + name + "]\nmodel = \"sfem\"\nsurface = \"" + name +
           ".obj\"\nresolution = 0.03\npatch = false\nfixed = \"back\"\n";
  };
  const std::map<std::string, std::string> left{{"[tool.needle]", organ("liver")},
                                                {"[body.gallbladder]", organ("liver") + organ("stomach")},
                                                {"[body.stone]", organ("liver")}};
  const auto found = left.find(block.substr(0, block.find('\n')));
  return found == left.end() ? "" : found->second;
}

/// Writes the scenes of the tutorials, as a reader saves them.
void write_tutorials(const fs::path& folder) {
  for (const auto& [page, scene] :
       {std::pair{"an-organ-under-a-finger.md", "organ.toml"}, {"cloth-on-a-body.md", "towel.toml"}})
    write(folder / scene, first_block(fs::path(TURGOR_SOURCE_DIR) / "docs" / page, "```toml\n"));
}

/// A folder with the scenes and the files that a reader would supply.
fs::path folder_of_a_reader() {
  const fs::path folder = fresh_folder();
  fs::copy(fs::path(TURGOR_SOURCE_DIR) / "scenes", folder / "scenes", fs::copy_options::recursive);
  const Ended made = run_program(
      "phantom torso --size 64 48 40 --spacing 6.5 6.5 6.5 -o patient --labels seg.nii.gz && '" TURGOR_PROGRAM
      "' phantom torso --size 64 48 40 --spacing 6.5 6.5 6.5 -o patient.nii.gz && '" TURGOR_PROGRAM
      "' phantom liver --detail 0.3 -o own.obj && cp own.obj liver.obj"
      " && printf 'time_s,x_m,y_m,z_m\\n0,0,0,0\\n1,0,0,0.001\\n' > poses.csv",
      folder);
  EXPECT_EQ(made.code, 0) << made.printed;
  write_tutorials(folder);
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

/// Overrides for a run that is only checked: blades and stitches start within the first second, and nothing
/// else depends on the duration. Fewer frames are timed then.
std::string fewer_frames(const std::string& arguments, const fs::path& folder) {
  std::string scene = arguments.substr(arguments.find(' ') + 1);
  scene = test::bytes_of(folder / scene.substr(0, scene.find(' ')));
  const auto has = [&](const char* table) { return scene.find(table) != scene.npos; };
  const bool has_wound = has("\n[incision") || has("\n[excision") || has("\n[suture");
  if (!has_wound) return " --set world.duration=0.05";
  const bool has_rate = arguments.find("frame_rate") != arguments.npos;
  return std::string(" --set world.duration=1.05") + (has_rate ? "" : " --set world.frame_rate=5");
}

/// A run without the options of the haptic loop and the conditions on its report, which exclude --check.
std::string without_report(const std::string& arguments) {
  static const std::regex flag(" --real-time"),
      valued(" --(device|tool|rate|device-file|device-address|require) (\"[^\"]*\"|[^ ]+)");
  return std::regex_replace(std::regex_replace(arguments, valued, ""), flag, "");
}

/// The same run of a scene that does not exist.
std::string of_missing_scene(const std::string& arguments) {
  static const std::regex scene("^run [^ ]+");
  return std::regex_replace(arguments, scene, "run nowhere.toml");
}

// Every run in the documents and scenes is accepted by --check, and the options that it excludes are read.
TEST(Documents, EveryRunPassesCheck) {
  const fs::path folder = folder_of_a_reader();
  std::set<std::string> done;
  for (const Command& command : all_commands()) {
    // a replay and an interrupted run are read instead of a scene
    const auto has = [&](const char* option) { return command.arguments.find(option) != std::string::npos; };
    if (!command.arguments.starts_with("run ") || has("--replay") || has("--resume")) continue;
    const std::string given = with_inputs(command.arguments), arguments = without_report(given) + " --check";
    if (given + " --check" != arguments) {
      const Ended missing = run_program(of_missing_scene(given), folder);
      EXPECT_NE(missing.printed.find("nowhere.toml"), std::string::npos) << command.where << missing.printed;
    }
    static const std::regex folder_of_results("--out [^ ]+ ");  // a check writes none
    if (!done.insert(std::regex_replace(arguments, folder_of_results, "")).second) continue;
    const Ended ended = run_program(arguments + fewer_frames(arguments, folder), folder);
    EXPECT_EQ(ended.code, 0) << command.where << ": turgor " << command.arguments << "\n" << ended.printed;
  }
  EXPECT_GT(done.size(), 12u);
}

// The hand of docs/devices.md begins outside the liver and presses it.
TEST(Documents, HandOfDevicesPressesLiver) {
  const fs::path folder = folder_of_a_reader();
  write(folder / "poses.csv", first_block(fs::path(TURGOR_SOURCE_DIR) / "docs/devices.md", "```\n",
                                          "## A hand from a file (`replay`)"));
  const Ended ended = run_program(
      "run scenes/palpation.toml --real-time --device replay --device-file poses.csv --out o -q "
      "--set world.duration=1.2 --set body.liver.resolution=0.02",
      folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  const nlohmann::json tool = report_in(folder / "o")["tools"][0];
  EXPECT_EQ(tool["series"][0][1], 0) << "the first force [N]: the hand begins outside";
  EXPECT_GT(tool["force_max_N"].get<double>(), 0.1);
}

// The cut of docs/from-your-ct-to-a-report.md lies on the skin of the phantom, where the page says, and
// opens.
TEST(Documents, CutInMetersReplacesFractions) {
  const fs::path folder = folder_of_a_reader();
  for (const Command& command :
       commands_in(fs::path(TURGOR_SOURCE_DIR) / "docs/from-your-ct-to-a-report.md")) {
    if (command.arguments.find("midline.from=") == command.arguments.npos) continue;
    const Ended ended = run_program(command.arguments +
                                        " --set body.torso.ct=patient.nii.gz --set world.duration=0.8 --set "
                                        "body.torso.spacing=0.013 -q --out o",
                                    folder);
    ASSERT_EQ(ended.code, 0) << ended.printed;
    const nlohmann::json wound = report_in(folder / "o")["wounds"][0];
    EXPECT_NEAR(wound["length_mm"].get<double>(), 100, 20) << "from z = 0.05 to -0.05 m";
    return;
  }
  ADD_FAILURE() << "the page has no cut in meters";
}

// The organ of the tutorial answers with a force that is proportional to its modulus.
TEST(Documents, OrganOfTutorialIsLinear) {
  const fs::path folder = folder_of_a_reader();
  double force[2];
  for (int scale : {1, 2}) {
    const Ended ended = run_program(
        "run organ.toml -q --force --out o --set body.liver.resolution=0.03 --set body.liver.patch=false "
        "--set body.liver.stiffness_scale=" +
            std::to_string(scale),
        folder);
    ASSERT_EQ(ended.code, 0) << ended.printed;
    force[scale - 1] = report_in(folder / "o")["tools"][0]["force_max_N"].get<double>();
  }
  EXPECT_GT(force[0], 0.05);
  EXPECT_NEAR(force[1] / force[0], 2, 0.01);
}

// Before it is pulled away, the towel of the tutorial rests on the ball with its weight.
TEST(Documents, TowelOfTutorialRestsOnBall) {
  const fs::path folder = folder_of_a_reader();
  const Ended ended = run_program(
      "run towel.toml -q --out o --set world.duration=1.4 --set body.towel.sheet.columns=24 --set "
      "body.towel.sheet.rows=24",
      folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  const nlohmann::json obstacle = report_in(folder / "o")["bodies"][0]["obstacles"][0];
  EXPECT_NEAR(obstacle["series"].back()[1].get<double>(), 0.3 * 0.16 * 9.81, 0.01);
}

// Every scene in the documents is accepted by --check. The exceptions are tested elsewhere: studies by
// test_document_blocks.py, the scene of a fifth model with its build, and scenes for GPUs where there is one.
TEST(Documents, EverySceneBlockPassesCheck) {
  const fs::path folder = folder_of_a_reader();
  for (const char* organ : {"gallbladder.obj", "stomach.obj"})
    fs::copy_file(folder / "own.obj", folder / organ);
  fs::copy_file(folder / "seg.nii.gz", folder / "SEG.nii.gz");
  fs::copy_file(folder / "patient.nii.gz", folder / "CT.nii.gz");
  int checked = 0;
  for (const TomlBlock& block : toml_blocks()) {
    const auto has = [&](const char* words) { return block.text.find(words) != block.text.npos; };
    if (has("[study]") || has("model = \"spring\"") || has("device = \"gpu\"")) continue;
    const std::string scene = block.text + left_to_reader(block.text);
    write(folder / "block.toml", scene);
    const std::string coarse = scene.find("\nct = ") == scene.npos ? "" : " --set body.torso.spacing=0.013",
                      no_voxels = scene.find("\nblock = ") == scene.npos ? "" : " --set body.torso.block=";
    const Ended ended =
        run_program("run block.toml --check --set world.duration=0.05" + coarse + no_voxels, folder);
    EXPECT_EQ(ended.code, 0) << block.where << "\n" << ended.printed;
    checked++;
  }
  EXPECT_GE(checked, 9);
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

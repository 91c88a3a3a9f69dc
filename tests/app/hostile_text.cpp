// Text that steers a terminal, in every kind of input file, in file names and in options. No output of the
// program contains it: neither standard output, standard error nor a report.
#include <algorithm>

#include "tests/app/program.hpp"

namespace turgor {
namespace {

using namespace test;

/// Window title, color, cleared screen, C1 as UTF-8 and as a byte, right-to-left, backspace and return.
const std::string kSteering =
    "\x1b]0;PWNED\x07\x1b[31mRED\x1b[2J\xc2\x9b"
    "31m\xe2\x80\xae\x9b"
    "5n\x08\x7fx\ry";

/// Text from the first byte that steers a terminal, escaped; empty without one.
std::string first_steering(const std::string& text) {
  const auto context = [&](std::size_t at) { return testing::PrintToString(text.substr(at, 40)); };
  for (std::size_t i = 0; i < text.size(); i++) {
    const auto byte = static_cast<unsigned char>(text[i]);
    if ((byte < 0x20 && byte != '\n' && byte != '\t') || byte == 0x7f) return context(i);
    if (byte == 0xc2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xa0)
      return context(i);
    if (text.compare(i, 3, "\xe2\x80\xae") == 0) return context(i);
    if (byte == 0x9b && (i == 0 || static_cast<unsigned char>(text[i - 1]) < 0x80)) return context(i);
  }
  return "";
}

const fs::path kFuzzCorpus = fs::path(TURGOR_SOURCE_DIR) / "tests/fuzz/corpus";

std::vector<fs::path> corpus_files(const std::string& kind) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(kFuzzCorpus / kind)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// Begin and length of every readable word in the first 4 kB of a file.
std::vector<std::pair<std::size_t, std::size_t>> readable_words(const std::string& bytes) {
  std::vector<std::pair<std::size_t, std::size_t>> words;
  const auto is_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '.'; };
  const std::size_t end = std::min<std::size_t>(bytes.size(), 4096);
  for (std::size_t at = 0; at < end;) {
    std::size_t next = at;
    while (next < end && is_word(bytes[next])) next++;
    if (next > at) words.emplace_back(at, next - at);
    at = next + 1;
  }
  return words;
}

/// Copies of a file in each of which hostile text takes the position of one word.
std::vector<std::string> with_steering_text(const std::string& bytes, std::size_t most) {
  const auto words = readable_words(bytes);
  const bool binary = bytes.substr(0, 4096).find('\0') != std::string::npos;
  std::vector<std::string> all;
  const std::size_t count = std::min(most, words.size());
  for (std::size_t n = 0; n < count; n++) {
    const auto [begin, size] = words[n * words.size() / count];
    std::string mutant = bytes;
    // lengths and offsets of a binary file stay as they are
    mutant.replace(begin, size, binary ? kSteering.substr(0, size) : kSteering);
    all.push_back(std::move(mutant));
  }
  return all;
}

class HostileText : public testing::Test {
 protected:
  /// Runs the program and looks at all it printed.
  Ended expect_plain(const std::string& arguments) {
    const Ended ended = run_program(arguments + " </dev/null", folder);
    EXPECT_LT(ended.code, 128) << arguments << "\n" << ended.printed;
    EXPECT_EQ(first_steering(ended.printed), "") << arguments;
    return ended;
  }
  /// Looks at every report and table in a folder.
  void expect_plain_reports(const fs::path& out) {
    for (const auto& entry : fs::recursive_directory_iterator(out)) {
      const std::string kind = entry.path().extension().string();
      if (kind != ".html" && kind != ".json" && kind != ".csv" && kind != ".svg") continue;
      EXPECT_EQ(first_steering(bytes_of(entry.path())), "") << entry.path();
      if (kind == ".json") expect_plain_values(read_json(entry.path()), entry.path());
    }
  }
  /// Looks at the texts of a report as a program prints them.
  void expect_plain_values(const nlohmann::json& text, const fs::path& file) {
    if (text.is_string()) {
      EXPECT_EQ(first_steering(text.get<std::string>()), "") << file;
    }
    if (text.is_structured())
      for (const auto& [key, value] : text.items()) {
        EXPECT_EQ(first_steering(key), "") << file;
        expect_plain_values(value, file);
      }
  }
  /// Runs `command` for mutants of every file of a corpus; FILE stands for the mutant.
  void sweep(const std::string& kind, const std::string& command, std::size_t most) {
    int refused = 0;
    for (const fs::path& file : corpus_files(kind))
      for (const std::string& mutant : with_steering_text(bytes_of(file), most)) {
        const std::string name = "m" + file.filename().string();
        write(folder / name, mutant);
        std::string arguments = command;
        for (std::size_t at; (at = arguments.find("FILE")) != std::string::npos;)
          arguments.replace(at, 4, name);
        refused += expect_plain(arguments).code == 2;
        if (fs::exists(folder / "o.json")) expect_plain_values(read_json(folder / "o.json"), file);
        if (fs::exists(folder / "o")) expect_plain_reports(folder / "o");
        fs::remove(folder / "o.json");
        fs::remove_all(folder / "o");
      }
    EXPECT_GT(refused, 0) << "no mutant of " << kind << " reached a message";
  }

  const fs::path folder = fresh_folder();
};

const char* const kSteeredPad = R"([world]
duration = 0.02
frame_rate = 50
[body.pad]
model = "sfem"
block = { size = [0.06, 0.06, 0.03], count = [2, 2, 1] }
fixed = "bottom"
cache = false
[tool.finger]
body = "pad"
shape = { sphere = 0.006 }
path = [[0, 0.03, 0.03, 0.04], [0.05, 0.03, 0.03, 0.034]]
[output]
snapshots = { every = 1, size = [64, 64] }
video = false
)";

// Fields of CT files: NRRD, MetaImage, NIfTI and DICOM.
TEST_F(HostileText, OfVolumesIsCleaned) { sweep("ct", "info FILE --json o.json", 8); }

// Sections, names and comments of volume meshes.
TEST_F(HostileText, OfSolidMeshesIsCleaned) { sweep("solid", "info FILE --json o.json", 8); }

// Words of surface meshes.
TEST_F(HostileText, OfSurfaceMeshesIsCleaned) { sweep("surface", "info FILE --json o.json", 8); }

// Cells of all tables: force curves, paths of tools, poses of a device.
TEST_F(HostileText, OfTablesIsCleaned) {
  write(folder / "pad.toml", kSteeredPad);
  sweep("table", "calibrate FILE -o o", 4);
  sweep("table", "run pad.toml -q --out o --set tool.finger.path=FILE", 4);
  sweep("table", "run pad.toml -q --out o --real-time --device replay --device-file FILE", 4);
}

// Keys and values of scenes.
TEST_F(HostileText, OfScenesIsCleaned) { sweep("scene", "run FILE --check", 8); }

// Texts of a recording, such as its format and its scene.
TEST_F(HostileText, OfRecordingsIsCleaned) {
  write(folder / "pad.toml", kSteeredPad);
  ASSERT_EQ(run_program("run pad.toml -q --real-time --out live", folder).code, 0);
  const auto expect_refused = [&](const fs::path& file, const std::string& word, const std::string& command) {
    std::string bytes = bytes_of(file);
    const std::size_t at = bytes.find(word);
    ASSERT_NE(at, std::string::npos) << file << " " << word;
    bytes.replace(at, word.size(), kSteering.substr(0, word.size()));
    write(folder / "m.h5", bytes);
    EXPECT_EQ(expect_plain(command).code, 2) << word;
  };
  const fs::path recording = kFuzzCorpus / "recording/recording.h5";
  for (const char* word : {"turgor recording", "[world]", "duration = 0.05", "[body.torso]", "phantom = "})
    expect_refused(recording, word, "run --replay m.h5 --out o");
  for (const char* word : {"turgor haptic", "[world]", "duration = 0.02", "[body.pad]"})
    expect_refused(folder / "live/haptic.h5", word, "replay m.h5 --out o");
}

// File names and values of options, in messages and in the reports of a run that succeeds.
TEST_F(HostileText, OfOptionsIsCleaned) {
  write(folder / "pad.toml", kSteeredPad);
  const std::string value =
      "\"$(printf '%b' '\\033]0;PWNED\\007\\033[2J\\302\\23331m\\342\\200\\256\\2335n\\ry')\"";
  for (const std::string before : {"",
                                   "info ",
                                   "info pad.toml --series ",
                                   "info a.nii --labels ",
                                   "import ",
                                   "mesh ",
                                   "phantom ",
                                   "phantom torso -o ",
                                   "calibrate ",
                                   "bench ",
                                   "validate ",
                                   "cache --folder ",
                                   "--threads ",
                                   "run ",
                                   "run pad.toml --out o --set ",
                                   "run pad.toml --out o --set body.pad.young=",
                                   "run pad.toml --out o --require ",
                                   "run pad.toml --out o --require 'tools.finger.force_max_N<'",
                                   "run pad.toml --real-time --out o --device ",
                                   "run pad.toml --real-time --out o --tool ",
                                   "run pad.toml --real-time --out o --rate ",
                                   "run pad.toml --real-time --out o --device replay --device-file ",
                                   "run pad.toml --real-time --out o --device inverse3 --device-address ",
                                   "devices --address ",
                                   "run --replay ",
                                   "replay ",
                                   "view --"})
    expect_plain(before + value);
  ASSERT_EQ(expect_plain("run pad.toml --out run" + value).code, 0);  // `value` is the folder of the phantom
  EXPECT_EQ(run_shell("cp pad.toml " + value + ".toml", folder).code, 0);
  ASSERT_EQ(expect_plain("run " + value + ".toml --out named --set 'output.color=\"none\"'").code, 0);
  expect_plain_reports(folder / "named");
  EXPECT_EQ(run_shell("cp '" + (kFuzzCorpus / "ct/a.nrrd").string() + "' " + value + ".nrrd", folder).code,
            0);
  ASSERT_EQ(expect_plain("info " + value + ".nrrd --json named.json").code, 0);
  expect_plain_values(read_json(folder / "named.json"), "named.json");
}

// A line end in a file name does not start a line of the output.
TEST_F(HostileText, OfFileNamesStaysOnOneLine) {
  fs::copy_file(kFuzzCorpus / "ct/a.nrrd", folder / "a\nturgor: note: forged.nrrd");
  const Ended info = expect_plain("info 'a\nturgor: note: forged.nrrd'");
  EXPECT_EQ(info.code, 0) << info.printed;
  EXPECT_EQ(info.printed.find("a turgor: note: forged.nrrd\n"), 0u) << info.printed;
}

// Names of labels in a segmentation are cleaned in the table and in the report.
TEST_F(HostileText, OfLabelNamesIsCleaned) {
  ASSERT_EQ(run_program("phantom torso --size 48 40 32 -o ct.nii.gz --labels l.nrrd", folder).code, 0);
  std::string bytes = bytes_of(folder / "l.nrrd");
  const std::string hostile = kSteering.substr(0, kSteering.find('\r'));
  bytes.insert(bytes.find("\n\n") + 1,
               "Segment0_LabelValue:=5\nSegment0_Layer:=0\nSegment0_Name:=" + hostile + "\n");
  write(folder / "l.seg.nrrd", bytes);
  const Ended info = expect_plain("info ct.nii.gz --labels l.seg.nrrd --json o.json");
  EXPECT_EQ(info.code, 0) << info.printed;
  EXPECT_NE(info.printed.find("PWNED"), std::string::npos) << info.printed;
  expect_plain_values(read_json(folder / "o.json"), "o.json");
}

}  // namespace
}  // namespace turgor

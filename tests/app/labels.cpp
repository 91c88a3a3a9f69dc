// A CT with a segmentation: names of labels, grids that differ, and the plausibility check of gray values.
#include <sstream>

#include "tests/app/program.hpp"

namespace turgor {
namespace {

using nlohmann::json;
using namespace test;

/// A phantom's CT and labels as files.
fs::path folder_with_ct() {
  const fs::path folder = fresh_folder();
  EXPECT_EQ(run_program("phantom torso --size 48 40 32 -o ct.nii.gz --labels l.nii.gz", folder).code, 0);
  return folder;
}

std::string scene_of(const std::string& body) {
  return "[world]\nduration = 0.02\nframe_rate = 50\n[body.torso]\nmodel = \"lattice\"\nct = "
         "\"ct.nii.gz\"\nblock = 2\n" +
         body +
         "\n[output]\nsnapshots = { every = 1, size = [80, 64] }\nvolume_rendering = false\nmeshes = false\n"
         "recording = false\nvideo = false\n";
}

/// The labels as 3D Slicer writes them: label 5, the liver, has another name.
void write_segmentation(const fs::path& folder, const std::string& name) {
  ASSERT_EQ(run_program("import l.nii.gz -o l.nrrd", folder).code, 0);
  std::string bytes = bytes_of(folder / "l.nrrd");
  bytes.insert(bytes.find("\n\n") + 1,
               "Segment0_LabelValue:=5\nSegment0_Layer:=0\nSegment0_Name:=" + name + "\n");
  write(folder / "l.seg.nrrd", bytes);
}

bool warns(const json& report, const std::string& words) {
  for (const json& warning : report["warnings"])
    if (warning.get<std::string>().find(words) != std::string::npos) return true;
  return false;
}

// The columns of the table stay straight under a name of 70 letters, some of them not ASCII.
TEST(Labels, LongNamesKeepColumns) {
  const fs::path folder = folder_with_ct();
  std::string name;
  for (int n = 0; n < 14; n++) name += "Größe";
  write_segmentation(folder, name);
  const Ended info = run_program("info ct.nii.gz --labels l.seg.nrrd", folder);
  ASSERT_EQ(info.code, 0) << info.printed;
  // the numbers of the fifth column end at the same character in every row
  constexpr std::size_t kEnd = 2 + 5 + 1 + 70 + 1 + 9 + 1 + 10 + 1 + 8;
  std::istringstream lines(info.printed.substr(info.printed.find("\n  label ") + 1));
  int rows = 0;
  for (std::string line; std::getline(lines, line) && !line.empty(); rows++) {
    std::erase_if(line, [](char c) { return (std::uint8_t(c) & 0xc0) == 0x80; });
    ASSERT_GT(line.size(), kEnd + 2) << line;
    EXPECT_NE(line[kEnd - 1], ' ') << line;
    EXPECT_EQ(line.substr(kEnd, 2), "  ") << line;
  }
  EXPECT_GT(rows, 5);
}

// Labels have the names of their file, in info and in scenes.
TEST(Labels, NamesComeFromFile) {
  const fs::path folder = folder_with_ct();
  write_segmentation(folder, "tumour");
  const Ended info = run_program("info ct.nii.gz --labels l.seg.nrrd", folder);
  EXPECT_EQ(info.code, 0) << info.printed;
  EXPECT_NE(info.printed.find("    5 tumour "), std::string::npos) << info.printed;
  EXPECT_EQ(info.printed.find("liver"), std::string::npos) << info.printed;
  EXPECT_EQ(info.printed.find("TotalSegmentator"), std::string::npos) << info.printed;
  write(folder / "s.toml",
        scene_of("labels = \"l.seg.nrrd\"\nonly = \"tumour\"\ntissue = { labels = { tumour = 9e3 } }"));
  const Ended run = run_program("run s.toml -o by-name", folder);
  ASSERT_EQ(run.code, 0) << run.printed;
  EXPECT_FALSE(warns(report_in(folder / "by-name"), "TotalSegmentator"));
  write(folder / "n.toml", scene_of("labels = \"l.seg.nrrd\"\nonly = 5\ntissue = { labels = { 5 = 9e3 } }"));
  ASSERT_EQ(run_program("run n.toml -o by-number", folder).code, 0);
  EXPECT_EQ(report_in(folder / "by-name")["state_hash"], report_in(folder / "by-number")["state_hash"]);
  write(folder / "w.toml", scene_of("labels = \"l.seg.nrrd\"\nonly = \"liver\""));
  const Ended wrong = run_program("run w.toml -o wrong", folder);
  EXPECT_EQ(wrong.code, 2);
  EXPECT_NE(wrong.printed.find("found \"liver\""), std::string::npos) << wrong.printed;
}

// The mesh command uses the names of the file and notes when it assumes those of TotalSegmentator.
TEST(Labels, MeshNotesAssumedNames) {
  const fs::path folder = folder_with_ct();
  write_segmentation(folder, "tumour");
  const Ended own = run_program("mesh l.seg.nrrd --label tumour --size 0.02 -o name.msh", folder);
  ASSERT_EQ(own.code, 0) << own.printed;
  EXPECT_EQ(own.printed.find("TotalSegmentator"), std::string::npos) << own.printed;
  ASSERT_EQ(run_program("mesh l.seg.nrrd --label 5 --size 0.02 -o number.msh", folder).code, 0);
  EXPECT_EQ(bytes_of(folder / "name.msh"), bytes_of(folder / "number.msh"));
  const Ended usual = run_program("mesh l.nii.gz --label liver --size 0.02 -o usual.msh", folder);
  ASSERT_EQ(usual.code, 0) << usual.printed;
  EXPECT_NE(usual.printed.find("\"liver\" is taken to be label 5, as TotalSegmentator numbers them"),
            std::string::npos)
      << usual.printed;
  EXPECT_EQ(bytes_of(folder / "usual.msh"), bytes_of(folder / "number.msh"));
  for (const auto& [label, words] :
       {std::pair("tumor",
                  "--label: expected a label's number (1 to 65535) or an organ's name, found \"tumor\"; "
                  "did you mean tumour?"),
        std::pair("70000", "found \"70000\""), std::pair("0", "found \"0\"")}) {
    const Ended wrong = run_program(std::string("mesh l.seg.nrrd -o no.msh --label ") + label, folder);
    EXPECT_EQ(wrong.code, 2);
    EXPECT_NE(wrong.printed.find(words), std::string::npos) << wrong.printed;
    EXPECT_FALSE(fs::exists(folder / "no.msh"));
  }
}

// A file without names of labels is noted by info and by run.
TEST(Labels, NotesMissingNames) {
  const fs::path folder = folder_with_ct();
  const Ended info = run_program("info ct.nii.gz --labels l.nii.gz", folder);
  EXPECT_NE(info.printed.find("names none of its labels"), std::string::npos) << info.printed;
  write(folder / "s.toml", scene_of("labels = \"l.nii.gz\"\nonly = \"liver\""));
  ASSERT_EQ(run_program("run s.toml -o out", folder).code, 0);
  EXPECT_TRUE(warns(report_in(folder / "out"), "\"liver\" is taken to be label 5, as TotalSegmentator"));
}

// Labels on another grid than the CT's are refused by info and by run.
TEST(Labels, RejectsForeignGrid) {
  const fs::path folder = folder_with_ct();
  ASSERT_EQ(run_program("phantom torso --size 48 40 30 -o other.nii.gz --labels o.nii.gz", folder).code, 0);
  write(folder / "s.toml", scene_of("labels = \"o.nii.gz\"\nonly = \"liver\""));
  for (const char* command : {"info ct.nii.gz --labels o.nii.gz", "run s.toml -o out"}) {
    const Ended ended = run_program(command, folder);
    EXPECT_EQ(ended.code, 2) << ended.printed;
    EXPECT_NE(
        ended.printed.find("o.nii.gz: its grid differs from the CT's: size 48 x 40 x 30, not 48 x 40 x 32"),
        std::string::npos)
        << ended.printed;
  }
  EXPECT_FALSE(fs::exists(folder / "out"));
}

// Labels given as a CT cause a warning in info, import and run.
TEST(Labels, WarnsIfUsedAsCt) {
  const fs::path folder = folder_with_ct();
  EXPECT_NE(run_program("info l.nii.gz", folder).printed.find("do not look like Hounsfield"),
            std::string::npos);
  EXPECT_NE(run_program("import l.nii.gz -o l.mha", folder).printed.find("do not look like Hounsfield"),
            std::string::npos);
  write(folder / "s.toml", scene_of("fixed = \"none\"\ngravity = false\nskin = false"));
  ASSERT_EQ(run_program("run s.toml -o out --set body.torso.ct=l.nii.gz", folder).code, 0);
  EXPECT_TRUE(warns(report_in(folder / "out"), "do not look like Hounsfield units"));
  ASSERT_EQ(run_program("run s.toml -o sound", folder).code, 0);
  EXPECT_FALSE(warns(report_in(folder / "sound"), "Hounsfield"));
}

}  // namespace
}  // namespace turgor

// Failed writes. The program ends with a message and an exit code, and earlier files stay unchanged.
#include <csignal>
#include <cstring>

#include "tests/app/program.hpp"

namespace turgor {
namespace {

using namespace test;

constexpr const char* kSmallDisk = "ulimit -f 8";  // blocks of 512 bytes, limit of every file

class FilesOut : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(run_program("phantom torso --size 24 20 16 -o ct.nii", folder).code, 0);
    write(folder / "s.toml", small_scene("", "video = false\nvolume_rendering = false\nmeshes = false\n"));
    before = names_in(folder);
  }
  /// Expects exit code 2, these words after "turgor: ", and no new file in the folder.
  void expect_refused(const std::string& arguments, const std::string& words,
                      const std::string& first = "true") {
    const Ended ended = run_program(arguments, folder, first);
    EXPECT_EQ(ended.code, 2) << arguments << "\n" << ended.printed;
    EXPECT_NE(ended.printed.find("turgor: "), std::string::npos) << arguments << "\n" << ended.printed;
    EXPECT_NE(ended.printed.find(words), std::string::npos) << arguments << "\n" << ended.printed;
    EXPECT_EQ(names_in(folder), before) << arguments;
  }

  /// Runs with one redirected stream; `printed` holds standard error.
  Ended run_redirected(const std::string& arguments, const std::string& redirection) {
    Ended ended = run_program(arguments + " 2>said " + redirection + " #", folder);
    ended.printed = bytes_of(folder / "said");
    return ended;
  }

  const fs::path folder = fresh_folder();
  std::set<std::string> before;
};

// On a full disk every command ends with a message and keeps earlier files.
TEST_F(FilesOut, FullDisk_EveryCommandKeepsFiles) {
  for (const char* name : {"a.nii", "a.nii.gz", "a.nrrd", "a.mha", "a.obj", "a.msh", "a.vtu"})
    write(folder / name, "earlier");
  write(folder / "curve.csv", "0,0\n0.001,0.1\n0.002,0.2\n0.003,0.3\n0.004,0.4\n0.005,0.5\n");
  ASSERT_EQ(run_program("phantom liver --detail 0.2 -o liver.obj", folder).code, 0);
  before = names_in(folder);
  const std::string full = ": cannot write the file: File too large";
  for (const char* name : {"a.nii", "a.nii.gz", "a.nrrd", "a.mha"})
    expect_refused(std::string("import ct.nii -o ") + name, name + full, kSmallDisk);
  expect_refused("phantom liver -o a.obj", "a.obj" + full, kSmallDisk);
  expect_refused("phantom torso --size 64 48 20 -o dicom", full, kSmallDisk);
  expect_refused("phantom torso --size 64 48 20 -o a.nrrd", "a.nrrd" + full, kSmallDisk);
  for (const char* name : {"a.msh", "a.vtu"})
    expect_refused(std::string("mesh liver.obj --size 0.02 -o ") + name, name + full, kSmallDisk);
  expect_refused("run s.toml -q --out out", "cannot write", kSmallDisk);
  expect_refused("calibrate curve.csv --out out", "cannot write", "ulimit -f 0");
  for (const char* name : {"a.nii", "a.nii.gz", "a.nrrd", "a.mha", "a.obj", "a.msh", "a.vtu"})
    EXPECT_EQ(bytes_of(folder / name), "earlier") << name;
}

// A disk that fills up during a recording ends the run with a message.
TEST_F(FilesOut, FullDisk_EndsRecordingRun) {
  for (const char* blocks : {"16", "64", "160", "300"})  // at the start, at a snapshot, at the end
    expect_refused("run s.toml -q --out out", "cannot write", std::string("ulimit -f ") + blocks);
}

// Errors of standard output are reported on standard error, after the results are written.
TEST_F(FilesOut, ReportsStdoutErrors) {
  const std::string full = "turgor: standard output: cannot be written: No space left on device";
  for (const char* arguments : {"info ct.nii", "--help", "--version", "", "run --help"}) {
    const Ended ended = run_redirected(arguments, ">/dev/full");
    EXPECT_EQ(ended.code, 2) << arguments;
    EXPECT_EQ(ended.printed, full + "\n") << arguments;
  }
  const Ended run = run_redirected("run s.toml --out out", ">/dev/full");
  EXPECT_EQ(run.code, 2);
  EXPECT_NE(run.printed.find(full), std::string::npos) << run.printed;
  EXPECT_TRUE(fs::exists(folder / "out" / "report.json")) << "the results are written first";
  const Ended closed = run_redirected("info ct.nii", ">&-");
  EXPECT_EQ(closed.code, 2);
  EXPECT_EQ(closed.printed, "turgor: standard output: cannot be written: Bad file descriptor\n");
}

// A run continues if standard error cannot be written.
TEST_F(FilesOut, StderrErrorsDoNotStopRun) {
  const std::string quick = "run s.toml -q --out out --set output.recording=false";
  ASSERT_EQ(run_program(quick, folder).code, 0);
  for (const char* closed_stream : {"2>/dev/full", "2>&-"}) {
    write(folder / "out" / "notes.md", "named on standard error");
    EXPECT_EQ(run_redirected(quick + " --force", closed_stream).code, 0) << closed_stream;
    EXPECT_FALSE(fs::exists(folder / "out" / "notes.md"));
  }
}

// A closed pipe ends the program with code 141 and without a message.
TEST_F(FilesOut, ClosedPipeEndsQuietly) {
  const std::string command = "cd '" + folder.string() +
                              "' && { '" TURGOR_PROGRAM
                              "' info ct.nii 2>err; echo $? >code; } | true; sleep 0.1";
  ASSERT_EQ(system(command.c_str()), 0);
  EXPECT_EQ(bytes_of(folder / "code"), "141\n");
  EXPECT_EQ(bytes_of(folder / "err"), "");
}

// JSON files that cannot be written, or that would replace an input, are refused.
TEST_F(FilesOut, ReportsJsonErrors) {
  expect_refused("info ct.nii --json /dev/full", "/dev/full: cannot write the file: No space left on device");
  expect_refused("info ct.nii --json none/a.json", "none/a.json: the folder none does not exist");
  expect_refused("info ct.nii --json ct.nii", "--json ct.nii: would replace an input file");
  expect_refused("bench rhombus --json none/a.json", "none/a.json: the folder none does not exist");
  EXPECT_TRUE(fs::is_character_file("/dev/full"));
}

// An output never replaces an input, also not a slice in an input folder.
TEST_F(FilesOut, OutputsNeverReplaceInputs) {
  const std::string ct = bytes_of(folder / "ct.nii");
  expect_refused("import ct.nii -o ct.nii", "-o ct.nii: would replace an input file");
  expect_refused("import ct.nii -o ./ct.nii", "would replace an input file");
  EXPECT_EQ(bytes_of(folder / "ct.nii"), ct);
  ASSERT_EQ(run_program("phantom torso --size 24 20 4 -o dicom", folder).code, 0);
  before = names_in(folder);
  const std::string slice = bytes_of(folder / "dicom" / "slice-00001.dcm");
  ASSERT_FALSE(slice.empty());
  expect_refused("info dicom --json dicom/slice-00001.dcm", "would replace an input file");
  EXPECT_EQ(bytes_of(folder / "dicom" / "slice-00001.dcm"), slice);
}

// An option that would be ignored is refused.
TEST_F(FilesOut, OptionsAreNeverIgnored) {
  write(folder / "curve.csv", "0,0\n0.001,0.1\n0.002,0.2\n0.003,0.3\n0.004,0.4\n0.005,0.5\n");
  before = names_in(folder);
  expect_refused("calibrate curve.csv --set world.dt=1 --out out", "--set changes scenes; this is a table");
  expect_refused("calibrate s.toml --tip 8 --out out", "--tip belongs to a table");
  expect_refused("phantom torso --size 24 20 4 --detail 5 -o a.nii", "only the liver has --detail");
  expect_refused("phantom forceps --detail 5 -o a.obj", "only the liver has --detail");
  expect_refused("phantom liver --seed 7 -o a.obj", "a surface has no --seed");
  expect_refused("import ct.nii --series 2 -o b.nii", "only DICOM");
  expect_refused("run s.toml --check --require nonsense", "--require");
}

// Outputs below a file or in a missing folder are refused before the work starts.
TEST_F(FilesOut, RejectsImpossibleOutputsEarly) {
  expect_refused("run s.toml --out ct.nii/out", "ct.nii");
  expect_refused("run s.toml --out ct.nii", "ct.nii: expected a folder for the results, found a file");
  expect_refused("import ct.nii -o ct.nii/a.nrrd", "ct.nii is not a folder");
  expect_refused("import ct.nii -o none/a.nrrd", "the folder none does not exist");
  expect_refused("mesh ct.nii --label 5 -o none/a.msh", "the folder none does not exist");
  expect_refused("phantom torso -o none/ct", "none does not exist");
  expect_refused("phantom torso -o ct.nii/ct", "ct.nii");
  expect_refused("phantom torso --size 16 16 16 -o a.nii --labels ./a.nii", "name the same file");
}

// A file that a user added to a result stops the next run; --force names and removes it.
TEST_F(FilesOut, ForeignFilesBlockNextRun) {
  const std::string quick = "run s.toml -q --out out --set output.recording=false";
  ASSERT_EQ(run_program(quick, folder).code, 0);
  ASSERT_EQ(run_program(quick, folder).code, 0) << "an unchanged result is replaced";
  write(folder / "out" / "notes.md", "seen twice");
  before = names_in(folder);
  expect_refused(quick, "out: holds files that turgor did not write, or that were changed since: notes.md;");
  EXPECT_EQ(bytes_of(folder / "out" / "notes.md"), "seen twice");
  const Ended forced = run_program(quick + " --force", folder);
  EXPECT_EQ(forced.code, 0) << forced.printed;
  EXPECT_NE(forced.printed.find("--force removes, with the earlier results: notes.md"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder / "out" / "notes.md"));
  EXPECT_EQ(names_in(folder), before);
}

// A run does not replace its own CT, and a replay does not replace its recording.
TEST_F(FilesOut, KeepsInputsInOutputFolder) {
  ASSERT_EQ(run_program("run s.toml -q --out out", folder).code, 0);
  before = names_in(folder);
  expect_refused("run --replay out/recording.h5 -q --out out", "out/recording.h5: is in ");
  EXPECT_TRUE(fs::exists(folder / "out" / "recording.h5"));
  expect_refused("run s.toml -q --out out --set body.torso.ct=out/deformed.nii.gz",
                 "out/deformed.nii.gz: is in ");
  EXPECT_TRUE(fs::exists(folder / "out" / "deformed.nii.gz"));
}

// A run that stops at non-finite values ends with code 3 and keeps its results.
TEST_F(FilesOut, NonFiniteRunKeepsResults) {
  write(folder / "stiff.toml",
        "[world]\nduration = 0.5\nframe_rate = 20\n[body.flag]\nmodel = \"cloth\"\nsheet = { corner = [0, 0, "
        "1], side = "
        "[1.5, 0, 0], up = [0, 0, 1], columns = 10, rows = 8 }\nfabric = { law = \"springs\", density = "
        "0.12, warp = 1e30, weft "
        "= 800, "
        "shear = 150, bend = 2 }\nsolver = { method = \"sweeps\" }\nwind = { velocity = [100, 0, 0] "
        "}\n[output]\nvideo = false\n");
  const Ended ended = run_program("run stiff.toml -q --out out", folder);
  EXPECT_EQ(ended.code, 3) << ended.printed;
  EXPECT_NE(ended.printed.find("turgor: stiff.toml: stopped after "), std::string::npos) << ended.printed;
  const nlohmann::json report = report_in(folder / "out");
  EXPECT_NE(report["warnings"].dump().find("the next step was not finite"), std::string::npos);
  EXPECT_NE(ended.printed.find("flag: a higher frame rate"), std::string::npos) << ended.printed;
  EXPECT_EQ(ended.printed.find("skin tension"), std::string::npos) << "the scene has no skin";
  EXPECT_FALSE(report["pictures"].empty());
  // the check of the scene finds it, too
  const Ended check = run_program("run stiff.toml --check", folder);
  EXPECT_EQ(check.code, 3) << check.printed;
  EXPECT_NE(check.printed.find("is not finite"), std::string::npos) << check.printed;
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // sanitizers reserve terabytes
// Too little memory for a file, or for a scene, is reported with its name.
TEST_F(FilesOut, TooLittleMemoryNamesFile) {
  const auto printed = [&](const std::string& arguments) {
    const Ended ended =
        run_shell("ulimit -v 600000 && '" TURGOR_PROGRAM "' --threads 1 " + arguments, folder);
    EXPECT_EQ(ended.code, 2) << ended.printed;
    return ended.printed;
  };
  std::string stl(84, '\0');
  const std::uint32_t triangles = 14000000;
  std::memcpy(stl.data() + 80, &triangles, sizeof triangles);
  write(folder / "huge.stl", stl);
  fs::resize_file(folder / "huge.stl", 84 + std::uintmax_t(50) * triangles);  // sparse
  EXPECT_NE(printed("info huge.stl").find("huge.stl: cannot be read: not enough memory"), std::string::npos);
  write(folder / "huge.toml",
        "[body.b]\nmodel = \"sfem\"\ncache = false\nblock = { size = [1, 1, 1], count = [200, 200, 200] }\n");
  EXPECT_NE(printed("run huge.toml -q --out huge").find("huge.toml: not enough memory"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder / "huge"));
}
#endif

// Two outputs with the same file name are refused with a message that names both keys.
TEST_F(FilesOut, RejectsOutputsWithEqualNames) {
  expect_refused("run s.toml --out out --set output.displacement=deformed.nii.gz",
                 "output.deformed_ct and output.displacement would be the same file, deformed.nii.gz");
  expect_refused("run s.toml --out out --set output.displacement=u.nrrd --set output.jacobian=u.nrrd",
                 "output.displacement and output.jacobian would be the same file, u.nrrd");
}

}  // namespace
}  // namespace turgor

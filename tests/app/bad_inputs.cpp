// Wrong inputs of the program. Each ends with exit code 2 and a message that names the mistake, and leaves no
// new file.
#include <cstdint>
#include <cstring>

#include "tests/app/program.hpp"
#include "turgor/core/gpu.hpp"

namespace turgor {
namespace {

using namespace test;

/// NIfTI-1 file of int16 with 2 mm voxels, all of one value.
std::string nifti(int nx, int ny, int nz, int value, std::size_t missing_bytes = 0) {
  std::string bytes(352, '\0');
  const auto write_at = [&](std::size_t at, auto v) { std::memcpy(bytes.data() + at, &v, sizeof v); };
  write_at(0, std::int32_t(348));
  const std::int16_t dim[8] = {3, std::int16_t(nx), std::int16_t(ny), std::int16_t(nz), 1, 1, 1, 1};
  std::memcpy(bytes.data() + 40, dim, sizeof dim);
  write_at(70, std::int16_t(4));   // int16
  write_at(72, std::int16_t(16));  // bits
  const float spacing[4] = {1, 2, 2, 2};
  std::memcpy(bytes.data() + 76, spacing, sizeof spacing);
  write_at(108, 352.0f);           // offset of the voxels
  write_at(112, 1.0f);             // slope
  bytes[123] = 2;                  // mm
  write_at(254, std::int16_t(1));  // sform
  const float rows[12] = {-2, 0, 0, 0, 0, -2, 0, 0, 0, 0, 2, 0};
  std::memcpy(bytes.data() + 280, rows, sizeof rows);
  std::memcpy(bytes.data() + 344, "n+1", 4);
  const std::int16_t voxel = std::int16_t(value);
  for (int n = 0; n < nx * ny * nz; n++) bytes.append(reinterpret_cast<const char*>(&voxel), 2);
  return bytes.substr(0, bytes.size() - missing_bytes);
}

struct Case {
  std::string arguments;  // after "turgor "
  std::string words;      // expected in the output
};

class BadInputs : public testing::Test {
 protected:
  void SetUp() override {
    write(folder / "good.toml", small_scene());
    write(folder / "unknown.toml", small_scene("skinn = false"));
    write(folder / "syntax.toml", "[world\n");
    write(folder / "empty.toml", "");
    write(folder / "pbd.toml", small_scene("solver = { method = \"pbd\" }"));
    write(folder / "tension.toml", small_scene("skin = { tension = 500 }"));
    write(folder / "twice.toml", small_scene() + "\n[world]\nduration = 1\n");
    write(folder / "nul.toml", std::string("[world]\0\n", 9));
    write(folder / "air.nii", nifti(24, 24, 24, -1000));
    write(folder / "solid.nii", nifti(24, 24, 24, 40));
    write(folder / "short.nii", nifti(24, 24, 24, 40, 5000));
    write(folder / "tiny.nii", nifti(2, 2, 2, 40));
    write(folder / "text.nii", "this is no image");
    write(folder / "text.nii.gz", "this is no image");
    write(folder / "picture.jpg", "no");
    write(folder / "not.h5", "no");
    fs::create_directory(folder / "empty-folder");
    fs::create_directory(folder / "thesis");
    write(folder / "thesis" / "chapter.tex", "work");
    before = names_in(folder);
  }
  void expect(const std::vector<Case>& cases) const {
    for (const Case& c : cases) {
      const Ended ended = run_program(c.arguments, folder);
      EXPECT_EQ(ended.code, 2) << c.arguments << "\n" << ended.printed;
      EXPECT_NE(ended.printed.find(c.words), std::string::npos)
          << "turgor " << c.arguments << "\nprinted:  " << ended.printed << "expected: " << c.words;
      EXPECT_TRUE(has_error_line(ended.printed)) << ended.printed;
      EXPECT_EQ(ended.printed.find("HDF5-DIAG"), std::string::npos);
      EXPECT_EQ(ended.printed.find("terminate called"), std::string::npos);
      EXPECT_EQ(names_in(folder), before) << c.arguments;
    }
  }

  const fs::path folder = fresh_folder();
  std::set<std::string> before;
};

// Wrong command lines end with a message that names the mistake.
TEST_F(BadInputs, CommandLines) {
  expect({
      {"rn good.toml", "rn is not a command; did you mean run?"},
      {"bench clot", "clot is not a command; did you mean cloth?"},
      {"run", "expected either a scene or --replay FILE"},
      {"run good.toml --replay not.h5", "expected either a scene or --replay FILE"},
      {"run good.toml --ouf x", "--ouf is not an option; did you mean --out?"},
      {"run good.toml --xyzzy", "--xyzzy is not an option; see turgor run --help"},
      {"run good.toml good.toml", "good.toml; see turgor run --help"},
      {"phantom heart -o o", "kind: expected torso, head, leg, liver or forceps, found heart"},
      {"identify good.toml", "table is missing: Two columns"},
      {"mesh good.toml", "--output is missing: "},
      {"info good.toml", "good.toml: expected a CT or a mesh, found a scene"},
      {"run good.toml --threads -3", "--threads"},
      {"run good.toml --threads many", "--threads"},
      {"run good.toml --set", "--set"},
      {"run good.toml --out thesis", "thesis: the folder is not empty and is not the output of a run"},
      {"run good.toml --out good.toml", "good.toml: expected a folder for the results, found a file"},
      {"run good.toml --out good.toml/out", "good.toml"},
  });
}

// A scene with device = "gpu" on a machine without a GPU ends with a message that says so.
TEST_F(BadInputs, MissingGpu) {
  if (const Result<Gpu> gpu = open_gpu(); gpu) GTEST_SKIP() << "this machine has a GPU: " << gpu->name;
  const std::string run = "run good.toml --out o --set world.device=gpu",
                    missing = "body.torso: world.device = \"gpu\": expected a";
  expect({{run + " --set body.torso.solver.ordering=slabs",
           "world.device = \"gpu\" needs solver.ordering = \"colors\"; remove ordering"},
          {run, missing},
          {run + " --set body.torso.solver.sleep_speed=0.001", missing},
          {run + " --set body.torso.skin.law=area --set body.torso.solver.method=pbd", missing}});
}

// Wrong scenes end with a message that names the file, the line and the key.
TEST_F(BadInputs, Scenes) {
  expect({
      {"run goood.toml --out o", "goood.toml: does not exist; did you mean good.toml?"},
      {"run thesis --out o", "thesis: expected a scene file (.toml), found a folder"},
      {"run empty.toml --out o", "body is missing: a scene needs at least one body"},
      {"run syntax.toml --out o", "syntax.toml:1:7: not TOML"},
      {"run nul.toml --out o", "nul.toml:1:"},
      {"run twice.toml --out o", "twice.toml:22:1: not TOML: "},
      {"run unknown.toml --out o",
       "unknown.toml:10:1: body.torso.skinn is not a key of a scene; did you mean skin?"},
      {"run pbd.toml --out o", "offers the area law only"},
      {"run tension.toml --out o", "expected less than the skin's stiffness, 300 N/m, found 500 N/m"},
      {"run good.toml --out o --set body.torso.block=65",
       "expected a whole number from 1 to 64 [voxels], found 65"},
      {"run good.toml --out o --set world.durtion=1",
       "world.durtion is not a key of a scene; did you mean duration?"},
      {"run good.toml --out o --set body.tors.block=1", "the scene has no body tors; did you mean torso?"},
      {"run good.toml --out o --set nonsense", "expected key=value"},
      {"run good.toml --out o --set incision.midline.body=head", "the scene has no body head"},
      {"run good.toml --out o --set incision.midline.depth=-1",
       "expected a number between 0 and 1 [m], found -1"},
      {"run good.toml --out o --set incision.midline.from=[9,9,9]", "given either in meters or in fractions"},
      {"run good.toml --out o --set incision.midline.from_fraction=[0.5,0.5,2]", "from 0 to 1"},
      {"run good.toml --out o --set output.deformed_ct=a.png", "ends in .nii, .nii.gz, .nrrd or .mha"},
  });
}

// Missing, short or foreign data files end with a message that names the file.
TEST_F(BadInputs, DataFiles) {
  const std::string set = "run good.toml --out o --set body.torso.ct=";
  expect({
      {set + "gone.nii", "gone.nii"},
      {set + "short.nii", "short.nii"},
      {set + "text.nii", "text.nii"},
      {set + "text.nii.gz", "text.nii.gz"},
      {set + "picture.jpg", "picture.jpg"},
      {set + "empty-folder", "empty-folder"},
      {set + "air.nii", "air"},
      {set + "tiny.nii", "body.torso"},
      {"run good.toml --out o --set body.torso.labels=gone.nii", "gone.nii"},
      {"run good.toml --out o --set body.torso.labels=text.nii", "text.nii"},
      {"run good.toml --out o --set body.torso.skin.direction_field=solid.nii", "solid.nii"},
      {"run --replay gone.h5 --out o", "gone.h5: expected an HDF5 file, found nothing"},
      {"run --replay not.h5 --out o", "not.h5: expected an HDF5 file, found something else"},
      {"run --replay thesis --out o", "thesis: expected an HDF5 file, found something else"},
  });
}

// An incision that misses the body is reported before the simulation starts.
TEST_F(BadInputs, IncisionOutsideBody) {
  std::string scene = small_scene();
  scene.replace(scene.find("from_fraction = [0.5, 0.0, 0.7]\nto_fraction = [0.5, 0.0, 0.3]"), 61,
                "from = [2, 2, 2]\nto = [2, 2, 3]");
  write(folder / "good.toml", scene);
  expect({{"run good.toml --out o", "good.toml:11:1: incision.midline: "}});
}

// The program prints its version, and its help has examples.
TEST(Program, PrintsVersionAndHelp) {
  const fs::path folder = fresh_folder();
  EXPECT_EQ(run_program("--version", folder).printed.find("turgor "), 0u);
  EXPECT_EQ(run_program("--version", folder).code, 0);
  EXPECT_NE(run_program("", folder).printed.find("turgor run scenes/incision.toml"), std::string::npos);
  const Ended help = run_program("run --help", folder);
  EXPECT_EQ(help.code, 0);
  EXPECT_NE(help.printed.find("--set body.torso.ct=patient.nii.gz"), std::string::npos) << help.printed;
}

}  // namespace
}  // namespace turgor

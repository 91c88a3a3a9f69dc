// Commands that handle data: phantom, info, import.
#include "tests/app/program.hpp"

namespace turgor::test {
namespace {

// A phantom written as DICOM, written as NIfTI or imported as NRRD has the same voxels and labels.
TEST(InfoCommand, FormatsHoldEqualPhantoms) {
  const fs::path folder = fresh_folder();
  const std::string phantom = "phantom torso --size 48 48 40 --seed 3 ";
  ASSERT_EQ(run_program(phantom + "--labels l.nii.gz -o ct", folder).code, 0);
  ASSERT_EQ(run_program(phantom + "-o ct.nii.gz", folder).code, 0);
  const Ended import = run_program("import ct/slice-00002.dcm -o imported.nrrd", folder);
  ASSERT_EQ(import.code, 0) << import.printed;
  nlohmann::json first;
  for (const char* path : {"ct", "ct.nii.gz", "imported.nrrd"}) {
    const Ended info =
        run_program(std::string("info ") + path + " --labels l.nii.gz --json out.json", folder);
    ASSERT_EQ(info.code, 0) << info.printed;
    EXPECT_NE(info.printed.find("liver"), std::string::npos) << info.printed;
    const nlohmann::json json = read_json(folder / "out.json");
    if (first.is_null()) first = json;
    EXPECT_EQ(json["size"], first["size"]);
    EXPECT_EQ(json["hu"], first["hu"]) << path;
    ASSERT_EQ(json["labels"].size(), first["labels"].size());
    for (std::size_t i = 0; i < json["labels"].size(); i++) {
      EXPECT_EQ(json["labels"][i]["voxels"], first["labels"][i]["voxels"]);
      EXPECT_NEAR(json["labels"][i]["centroid_ras_mm"][0].get<double>(),
                  -first["labels"][i]["centroid_lps_mm"][0].get<double>(), 1e-3);
    }
  }
}

// Impossible commands end with a message and leave no files.
TEST(InfoCommand, ErrorsLeaveNoFiles) {
  const fs::path folder = fresh_folder();
  ASSERT_EQ(run_program("phantom leg --size 16 16 12 -o ct", folder).code, 0);
  write(folder / "flat.mesh",
        "MeshVersionFormatted 1 Dimension 3 Vertices 4  0 0 0 0  1 0 0 0  0 1 0 0  1 1 0 0 Tetrahedra 1  1 2 "
        "3 4 0");
  const struct {
    const char* command;
    int code;
    const char* words;
  } cases[] = {{"info cts", 2, "did you mean ct?"},
               {"info ct --labels nothing.nii.gz", 2, "nothing.nii.gz: does not exist"},
               {"info ct --series 7", 2, "no series \"7\""},
               {"info ct --scale 0.001", 2, "--scale applies to meshes"},
               {"info flat.mesh --series 7", 2, "--labels and --series apply to CTs"},
               {"info flat.mesh", 2, "expected tetrahedra with a volume, found 1 flat: 1"},
               {"info flat.mesh --scale 0", 2, "--scale"},
               {"import ct -o a.jpg", 2, "expected .nii, .nii.gz, .nrrd or .mha"},
               {"phantom leg --size 8 8 8 -o ct", 2, "not an empty folder"},
               {"phantom arm -o arm", 2, "arm"},
               {"phantom leg --size 0 8 8 -o leg", 2, "--size"}};
  for (const auto& c : cases) {
    const Ended ended = run_program(c.command, folder);
    EXPECT_EQ(ended.code, c.code) << c.command << ": " << ended.printed;
    EXPECT_NE(ended.printed.find(c.words), std::string::npos) << c.command << ": " << ended.printed;
  }
  EXPECT_EQ(names_in(folder), (std::set<std::string>{"ct", "flat.mesh"}));
}

// An incomplete DICOM series is refused; the message lists its missing slices.
TEST(InfoCommand, DescribesIncompleteSeries) {
  const fs::path folder = fresh_folder();
  ASSERT_EQ(run_program("phantom leg --size 16 16 12 -o ct", folder).code, 0);
  fs::remove(folder / "ct" / "slice-00005.dcm");
  const Ended ended = run_program("info ct", folder);
  EXPECT_EQ(ended.code, 2);
  for (const char* words : {"missing slices: 1 of 12", "slice-00004.dcm", "11 slices of 16 x 16"})
    EXPECT_NE(ended.printed.find(words), std::string::npos) << ended.printed;
}

// A mesh in another unit than meters is asked about by `info` and by a run, unless its scale is given.
TEST(InfoCommand, AsksAboutUnit) {
  const fs::path folder = fresh_folder();
  ASSERT_EQ(run_program("phantom liver --detail 0.3 -o m.obj", folder).code, 0);
  ASSERT_EQ(
      run_shell("awk '$1 == \"v\" { $2 *= 1000; $3 *= 1000; $4 *= 1000 } { print }' m.obj > mm.obj", folder)
          .code,
      0);
  write(folder / "s.toml", "[body.liver]\nmodel = \"sfem\"\nsurface = \"mm.obj\"\n");
  const std::string question = "is it in mm? scale = 0.001";
  const auto asks = [&](const Ended& ended) { return ended.printed.find(question) != ended.printed.npos; };
  EXPECT_TRUE(asks(run_program("info mm.obj", folder)));
  EXPECT_FALSE(asks(run_program("info mm.obj --scale 0.001", folder)));
  for (const char* command : {"run s.toml --out out", "run s.toml --check"}) {
    const Ended ended = run_program(command, folder);
    EXPECT_EQ(ended.code, 2) << ended.printed;
    EXPECT_TRUE(asks(ended)) << ended.printed;
  }
}

// The description of a solid mesh has its elements, regions, volume and angles.
TEST(InfoCommand, DescribesSolidMesh) {
  const fs::path folder = fresh_folder();
  write(folder / "two.mesh",
        "MeshVersionFormatted 1 Dimension 3 Vertices 5  0 0 0 0  10 0 0 0  0 10 0 0  0 0 10 0  0 0 -10 0\n"
        "Tetrahedra 2  1 2 3 4 3  1 2 3 5 4 End");
  const Ended info = run_program("info two.mesh --scale 0.001 --json out.json", folder);
  ASSERT_EQ(info.code, 0) << info.printed;
  for (const char* words : {"Medit", "2 tetrahedra, 5 vertices", "volume       0.333333 mL", "10 to 14.14 mm",
                            "54.74 to 90.00 degrees", "region       4: 1 element, 0.166667 mL",
                            "1 of 2 tetrahedra were inverted"})
    EXPECT_NE(info.printed.find(words), std::string::npos) << words << "\n" << info.printed;
  const nlohmann::json json = read_json(folder / "out.json");
  EXPECT_EQ(json["kind"], "tetrahedra");
  EXPECT_EQ(json["inverted_repaired"], 1);
  EXPECT_EQ(json["components"], 1);
  EXPECT_EQ(json["surface_triangles"], 6);
  EXPECT_NEAR(json["volume_m3"].get<double>(), 1e-6 / 3, 1e-18);
}

// The description of a surface says whether it is closed and bounds a body.
TEST(InfoCommand, DescribesSurface) {
  const fs::path folder = fresh_folder();
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n";
  write(folder / "closed.obj", corners + "f 3 1 4\n");
  write(folder / "open.obj", corners);
  const Ended closed = run_program("info closed.obj", folder), open = run_program("info open.obj", folder);
  EXPECT_EQ(closed.code, 0);
  EXPECT_NE(closed.printed.find("closed       yes"), std::string::npos) << closed.printed;
  EXPECT_NE(closed.printed.find("volume       166667 mL"), std::string::npos) << closed.printed;
  EXPECT_EQ(open.code, 0);
  EXPECT_NE(open.printed.find("closed       no"), std::string::npos) << open.printed;
  EXPECT_NE(open.printed.find("not a closed surface of a body: "), std::string::npos) << open.printed;
}

// The help of every command has an example.
TEST(InfoCommand, HelpHasExamples) {
  for (const std::string command : {"run", "info", "import", "phantom", "mesh", "calibrate", "validate sfem",
                                    "bench skin-tension", "bench sfem", "bench rhombus", "bench cloth"}) {
    const Ended help = run_program(command + " --help", fresh_folder());
    EXPECT_EQ(help.code, 0);
    const std::size_t examples = help.printed.find("\nExample");
    ASSERT_NE(examples, std::string::npos) << help.printed;
    EXPECT_NE(help.printed.find("\n  turgor " + command, examples), std::string::npos) << help.printed;
  }
}

}  // namespace
}  // namespace turgor::test

// Rhombus chains from the command line: phantoms, a run with forceps and its replay, a calibration.
#include <cmath>

#include "tests/app/program.hpp"

namespace turgor {
namespace {

using nlohmann::json;
using namespace test;

constexpr const char* kForceps = R"([world]
duration = 1.6
[body.liver]
model = "rhombus"
surface = "liver.obj"
[tool.jaws]
body = "liver"
shape = { forceps = "forceps.obj", opening = 0.012, closing = 0.1 }
grasp = { at_fraction = [0.3, 0.5, 1], depth = 0.005, pull = 0.012, duration = 0.3, hold = 0.15 }
[output]
snapshots = { every = 0.4, size = [240, 180] }
video = false
)";

// The phantoms of a liver and forceps suffice for a run, and its replay writes the same files.
TEST(RhombusRun, ForcepsRunOnPhantoms) {
  const fs::path folder = fresh_folder();
  EXPECT_NE(
      run_program("phantom liver -o liver.obj", folder).printed.find("3116 vertices and 6228 triangles"),
      std::string::npos);
  EXPECT_NE(
      run_program("phantom forceps -o forceps.obj", folder).printed.find("174 vertices and 348 triangles"),
      std::string::npos);
  write(folder / "s.toml", kForceps);
  const Ended ended = run_program("run s.toml --out first --set output.pictures=all", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  const json report = report_in(folder / "first");
  EXPECT_EQ(report["bodies"][0]["vertices"], 3116);
  EXPECT_GT(report["tools"][0]["force_max_N"].get<double>(), 0.02);
  EXPECT_LT(report["bodies"][0]["jump_per_10_um_N"].get<double>(),
            0.02 * report["tools"][0]["force_max_N"].get<double>());
  EXPECT_GT(report["profiles"][0]["rows"].size(), 10u);

  ASSERT_EQ(run_program("run --replay first/recording.h5 --out again", folder).code, 0);
  for (const char* name : {"forces.csv", "liver-near.png", "liver-whole.png"})
    EXPECT_EQ(bytes_of(folder / "first" / name), bytes_of(folder / "again" / name)) << name;
}

// The command calibrate fits a measured force curve within 10 percent.
TEST(RhombusRun, CalibratesMeasuredCurve) {
  const fs::path folder = fresh_folder();
  std::string curve = "depth_m,force_N\n";
  for (int i = 0; i <= 20; i++)
    curve += std::to_string(i * 5e-4) + "," + std::to_string(120 * std::pow(i * 5e-4, 1.2)) + "\n";
  write(folder / "curve.csv", curve);
  const Ended ended = run_program("calibrate curve.csv --out fit", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  EXPECT_NE(ended.printed.find("within 10 %"), std::string::npos) << ended.printed;
  EXPECT_NE(ended.printed.find("curve.csv read as m, N"), std::string::npos) << ended.printed;
  const json report = report_in(folder / "fit");
  EXPECT_LT(report["residual_largest"].get<double>(), 0.10);
  EXPECT_TRUE(report["accepted"].get<bool>());
  EXPECT_GT(bytes_of(folder / "fit" / "curve.csv").size(), 200u);
}

// A table that no chain can follow ends with a message that names it, and leaves no folder.
TEST(RhombusRun, UnfitTablesLeaveNoFolder) {
  const fs::path folder = fresh_folder();
  write(folder / "falls.csv", "depth_mm,force_N\n0,400\n4.5,1.7\n5,2\n5.5,2.3\n6,2.6\n7,2.8\n8,3\n");
  write(folder / "huge.csv", "0.0001 1e300\n0.002 1e300\n0.003 1e301\n0.004 1e302\n0.005 1e303\n");
  const std::pair<const char*, const char*> table[] = {
      {"falls.csv",
       "falls.csv: point 0 of the force-depth curve: expected no force at a depth of 0, found 400 N"},
      {"huge.csv", "huge.csv: point 0 of the force-depth curve: expected a force of at most 1e+06 N"}};
  for (const auto& [name, expected] : table) {
    const Ended ended = run_program(std::string("calibrate ") + name + " --out results/fit", folder);
    EXPECT_EQ(ended.code, 2) << ended.printed;
    EXPECT_NE(ended.printed.find(expected), std::string::npos) << ended.printed;
    EXPECT_TRUE(!fs::exists(folder / "results") || fs::is_empty(folder / "results")) << name;
  }
}

// Wrong inputs end with a message that says what was expected.
TEST(RhombusRun, WrongInputsEndWithMessage) {
  const fs::path folder = fresh_folder();
  const auto printed = [&](const std::string& arguments) {
    const Ended ended = run_program(arguments, folder);
    EXPECT_EQ(ended.code, 2) << ended.printed;
    return ended.printed;
  };
  EXPECT_NE(printed("phantom liver -o liver.stl").find("ends in .obj"), std::string::npos);
  EXPECT_NE(printed("phantom liver --size 8 8 8 -o liver.obj").find("a surface has no --size"),
            std::string::npos);
  EXPECT_NE(printed("calibrate missing.csv").find("missing.csv"), std::string::npos);
  write(folder / "stone.csv", "Distance (mm),Force (stone)\n0,0\n1,5\n2,10\n3,15\n");
  EXPECT_NE(printed("calibrate stone.csv").find("found \"stone\""), std::string::npos);
  write(folder / "few.csv", "0,0\n0.001,0.1\n");
  EXPECT_NE(printed("calibrate few.csv").find("at least 4 points"), std::string::npos);
  write(folder / "open.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nf 1 2 3\n");
  write(folder / "open.toml", "[body.b]\nmodel = \"rhombus\"\nsurface = \"open.obj\"\n");
  EXPECT_NE(printed("run open.toml").find("the surface is open: 3 edges"), std::string::npos);
  write(folder / "jaws.toml",
        "[body.b]\nmodel = \"rhombus\"\nsurface = { phantom = \"liver\" }\n[tool.t]\nbody = \"b\"\n"
        "shape = { forceps = \"open.obj\" }\ngrasp = { at_fraction = [0.5, 0.5, 1] }\n");
  EXPECT_NE(printed("run jaws.toml").find("jaw"), std::string::npos);
}

}  // namespace
}  // namespace turgor

// `turgor identify` from the command line.
#include "tests/app/program.hpp"

namespace turgor {
namespace {

using nlohmann::json;
using namespace test;

constexpr const char* kPress = R"([world]
duration = 0.1
[body.pad]
model = "sfem"
block = { size = [0.06, 0.06, 0.03], count = [6, 6, 3] }
fixed = "bottom"
young = 4000
poisson = 0.4
patch = { radius = 0.013, refinement = 2 }
[tool.finger]
body = "pad"
shape = { sphere = 0.012 }
friction = 0
press = { at_fraction = [0.5, 0.5, 1], depth = 0.002, start = 0, duration = 0.1, hold = 0 }
)";

// A table fits Young's modulus, in proportion to its forces; wrong input ends with code 2 and leaves no
// folder.
TEST(IdentifyCommand, FitsTableAndRefusesWrongInput) {
  const fs::path folder = fresh_folder();
  write(folder / "press.toml", kPress);
  write(folder / "soft.csv", "depth_mm,force_mN\n0.4,8\n0.8,22\n1.2,40\n1.6,60\n");
  write(folder / "stiff.csv", "depth_mm,force_mN\n0.4,16\n0.8,44\n1.2,80\n1.6,120\n");
  double young[2] = {};
  for (const int n : {0, 1}) {
    const std::string table = n == 0 ? "soft" : "stiff";
    const Ended ended =
        run_program("identify press.toml " + table + ".csv --fit body.pad.young=3000 -o " + table, folder);
    ASSERT_EQ(ended.code, 0) << ended.printed;
    EXPECT_NE(ended.printed.find("95 % interval"), std::string::npos);
    EXPECT_NE(ended.printed.find(table + ".csv read as mm, mN"), std::string::npos) << ended.printed;
    const json report = report_in(folder / table);
    EXPECT_TRUE(report["converged"].get<bool>());
    young[n] = report["parameters"][0]["value"];
    EXPECT_TRUE(fs::exists(folder / table / "curve.csv"));
  }
  EXPECT_NEAR(young[1], 2 * young[0], 0.01 * young[1]);

  write(folder / "bad.csv", "depth_mm,force_N\n0.4,8\nx,22\n");
  write(folder / "deep.csv", "depth_mm,force_mN\n0.4,8\n0.8,22\n1.2,40\n16,60\n");
  write(folder / "stone.csv", "Distance (mm),Force (stone)\n0.4,8\n0.8,22\n1.2,40\n1.6,60\n");
  for (const char* wrong :
       {"bad.csv --fit body.pad.young=3000", "stone.csv --fit body.pad.young=3000",
        "soft.csv --fit body.pad.young=-3", "soft.csv --fit body.pad.yuong=3",
        "deep.csv --fit body.pad.young=3000", "soft.csv --fit body.pad.young=3000 --tool none"}) {
    const Ended ended = run_program(std::string("identify press.toml ") + wrong + " -o wrong", folder);
    EXPECT_EQ(ended.code, 2) << wrong << ": " << ended.printed;
    EXPECT_FALSE(fs::exists(folder / "wrong")) << wrong;
  }
}

// Two tables of one tool are fitted together, each with its own curve and residual.
TEST(IdentifyCommand, FitsTwoTablesTogether) {
  const fs::path folder = fresh_folder();
  write(folder / "press.toml", kPress);
  write(folder / "deep.csv", "depth_mm,force_mN\n0.4,8\n0.8,22\n1.2,40\n1.6,60\n");
  write(folder / "late.csv", "time_ms,force_mN\n40,22\n60,40\n80,60\n");
  const std::string fit = "identify press.toml deep.csv late.csv --fit body.pad.young=3000";
  const Ended ended = run_program(fit + " --tool finger --tool finger -o both", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  const json report = report_in(folder / "both");
  ASSERT_EQ(report["tables"].size(), 2u);
  EXPECT_EQ(report["tables"][0]["rows"], 4);
  EXPECT_EQ(report["tables"][1]["rows"], 3);
  EXPECT_EQ(report["tables"][1]["tool"], "finger");
  EXPECT_GT(report["tables"][1]["residual"].get<double>(), 0);
  for (const char* file : {"curve-1.csv", "curve-2.csv", "force-1.svg", "force-2.svg"})
    EXPECT_TRUE(fs::exists(folder / "both" / file)) << file;
  const Ended many = run_program(fit + " --tool finger --tool finger --tool finger -o many", folder);
  EXPECT_EQ(many.code, 2) << many.printed;
}

}  // namespace
}  // namespace turgor

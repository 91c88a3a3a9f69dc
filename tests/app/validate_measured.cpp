// `turgor validate measured` as a user runs it.
#include "tests/app/program.hpp"

namespace turgor {
namespace {

using nlohmann::json;
using namespace test;

// Every row has a measured value inside its band; a prediction outside is a miss, printed and reflected in
// the exit code.
TEST(ValidateMeasuredCommand, MissesArePrinted) {
  const fs::path folder = fresh_folder();
  const Ended ended = run_program("validate measured --quick --out measured", folder);
  const json report = report_in(folder / "measured");
  ASSERT_GE(report["rows"].size(), 20u);
  std::size_t missed = 0, of_brain = 0, of_febio = 0;
  for (const json& row : report["rows"]) {
    const double measured = row["measured"], low = row["low"], high = row["high"], found = row["predicted"];
    EXPECT_TRUE(low <= measured && measured <= high) << row;
    EXPECT_EQ(row["inside"].get<bool>(), low <= found && found <= high) << row;
    EXPECT_NE(row["source"], "");
    EXPECT_NE(ended.printed.find(row["name"].get<std::string>()), std::string::npos);
    missed += !row["inside"].get<bool>();
    const std::string name = row["name"];
    of_brain += name.starts_with("brain, ");
    of_febio += name.starts_with("FEBio ");
    if (name.starts_with("FEBio ")) {
      // the same law; another volume term at small strains, and at a stretch of 2
      const std::string problem = name.substr(6, 4);
      const bool same = problem == "ma01" || problem == "mi09" || problem == "mi27";
      EXPECT_NEAR(found / measured, 1, same ? 1e-4 : problem.starts_with("ma") ? 2e-3 : 0.014) << row;
    }
  }
  EXPECT_EQ(of_brain, 12u) << "three tests of two regions, two figures each";
  EXPECT_EQ(of_febio, 8u);
  EXPECT_EQ(ended.code, missed > 0 ? 3 : 0) << ended.printed;
  EXPECT_EQ(report["missed"].size(), missed);
  for (const char* curve : {"brain-cortex-shear.svg", "muscle-along-exponential.svg",
                            "skin-equibiaxial-y-body.svg", "cantilever.svg"})
    EXPECT_TRUE(fs::exists(folder / "measured" / curve)) << curve;
}

// Four figures of a disc cut out of skin, with their measured values: the tensions are fitted to the
// specimen, so that its rows are inside. The wound is predicted.
TEST(ValidateMeasuredCommand, ExcisedDiscHasFourFigures) {
  const fs::path folder = fresh_folder();
  run_program("validate measured --quick --out measured", folder);
  const json report = report_in(folder / "measured");
  std::vector<double> measured;
  for (const json& row : report["rows"]) {
    const std::string name = row["name"];
    if (!name.starts_with("excised disc")) continue;
    measured.push_back(row["measured"]);
    EXPECT_EQ(double(row["high"]) - double(row["low"]), 8) << "points, " << row;
    if (name.ends_with("(fitted)")) {
      EXPECT_TRUE(row["inside"].get<bool>()) << row;
    }
    if (name.ends_with("wound along")) {
      EXPECT_GT(double(row["predicted"]), 0) << row;
    }
  }
  EXPECT_EQ(measured, (std::vector<double>{-23, -10, 16, -10}));
}

}  // namespace
}  // namespace turgor

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
  std::size_t missed = 0;
  for (const json& row : report["rows"]) {
    const double measured = row["measured"], low = row["low"], high = row["high"], found = row["predicted"];
    EXPECT_TRUE(low <= measured && measured <= high) << row;
    EXPECT_EQ(row["inside"].get<bool>(), low <= found && found <= high) << row;
    EXPECT_NE(row["source"], "");
    EXPECT_NE(ended.printed.find(row["name"].get<std::string>()), std::string::npos);
    missed += !row["inside"].get<bool>();
  }
  EXPECT_EQ(ended.code, missed > 0 ? 3 : 0) << ended.printed;
  EXPECT_EQ(report["missed"].size(), missed);
  for (const char* curve : {"muscle-along-exponential.svg", "skin-equibiaxial-y-body.svg", "cantilever.svg"})
    EXPECT_TRUE(fs::exists(folder / "measured" / curve)) << curve;
}

}  // namespace
}  // namespace turgor

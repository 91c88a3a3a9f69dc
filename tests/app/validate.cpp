// `turgor validate` as users and CI run it.
#include "tests/app/program.hpp"

namespace turgor {
namespace {

using nlohmann::json;
using namespace test;

// Every figure has bounds, and figures outside of them are marked as missed.
TEST(ValidateCommand, FiguresHaveBounds) {
  const fs::path folder = fresh_folder();
  const Ended ended = run_program("validate cloth --quick --out cloth", folder);
  EXPECT_EQ(ended.code, 0) << ended.printed;
  EXPECT_EQ(ended.printed.find("validate cloth: "), 0u) << "the expected cost is printed first";
  const json report = report_in(folder / "cloth");
  EXPECT_EQ(report["missed"].size(), 0u);
  int limits = 0;
  for (const json& figure : report["figures"]) {
    const double found = figure["found"], most = figure["most"];
    EXPECT_EQ(figure["missed"].get<bool>(), !(found <= most && found >= figure.value("least", found)));
    if (!figure.contains("known_limit")) continue;
    limits++;
    EXPECT_TRUE(figure["missed"].get<bool>()) << "no longer a known failure: give it a bound";
  }
  EXPECT_EQ(limits, 0) << "sheets have no known failure";
}

// An unknown model is refused.
TEST(ValidateCommand, RejectsUnknownModel) {
  const Ended ended = run_program("validate jelly", fresh_folder());
  EXPECT_EQ(ended.code, 2);
}

}  // namespace
}  // namespace turgor

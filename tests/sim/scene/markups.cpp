#include "turgor/sim/scene/markups.hpp"

#include <fstream>

#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "turgor/sim/scene/scene.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

/// A file as 3D Slicer 5 writes it, with these points.
std::string markups_text(const std::string& type, const std::string& points,
                         const std::string& system = "LPS", const std::string& units = "\"mm\"") {
  return R"({"@schema": "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/)"
         R"(Resources/Schema/markups-schema-v1.0.3.json#", "markups": [{"type": ")" +
         type + R"(", "coordinateSystem": ")" + system + R"(", "coordinateUnits": )" + units +
         R"(, "locked": false, "controlPoints": [)" + points + "]}]}";
}
std::string point(const std::string& position, const std::string& status = "defined") {
  return R"({"id": "1", "label": "C-1", "description": "", "position": )" + position +
         R"(, "orientation": [-1, 0, 0, 0, -1, 0, 0, 0, 1], "selected": true, "positionStatus": ")" + status +
         R"("})";
}
const std::string kThree = point("[10, -20, 30]") + "," + point("[40, -20, 30]") + "," + point("[40, 5, 30]");

std::string markup_error(const std::string& text) {
  const Result<Markup> markup = parse_markup(text, "cut.mrk.json");
  return markup ? "no error" : markup.error().message;
}

// A line becomes two points in meters.
TEST(Markups, LineIsReadInMeters) {
  const auto line =
      parse_markup(markups_text("Line", point("[10, -20, 30]") + "," + point("[40, -20, 30]")), "");
  ASSERT_TRUE(line) << line.error().message;
  EXPECT_TRUE(line->is_line);
  ASSERT_EQ(line->points.size(), 2u);
  EXPECT_LT(norm(line->points[0] - Vec3d{0.01, -0.02, 0.03}), 1e-12);
  EXPECT_LT(norm(line->points[1] - Vec3d{0.04, -0.02, 0.03}), 1e-12);
}

// RAS differs from LPS in the signs of x and y; centimeters are ten millimeters.
TEST(Markups, RasAndOtherUnitsAreConverted) {
  const auto curve = parse_markup(markups_text("Curve", kThree, "RAS"), "");
  ASSERT_TRUE(curve) << curve.error().message;
  EXPECT_FALSE(curve->is_line);
  EXPECT_LT(norm(curve->points[0] - Vec3d{-0.01, 0.02, 0.03}), 1e-12);
  const auto coded =
      parse_markup(markups_text("Curve", kThree, "LPS", R"(["cm", "UCUM", "centimeter"])"), "");
  ASSERT_TRUE(coded) << coded.error().message;
  EXPECT_LT(norm(coded->points[2] - Vec3d{0.4, 0.05, 0.3}), 1e-12);
}

// A closed curve ends at its first point; points without a position are left out.
TEST(Markups, ClosedCurveEndsAtItsFirstPoint) {
  const auto closed =
      parse_markup(markups_text("ClosedCurve", kThree + "," + point("[0, 0, 0]", "undefined")), "");
  ASSERT_TRUE(closed) << closed.error().message;
  ASSERT_EQ(closed->points.size(), 4u);
  EXPECT_EQ(closed->points.front(), closed->points.back());
}

// Errors name the file, the location and what was found.
TEST(Markups, ErrorsNamePlaceAndValue) {
  EXPECT_EQ(markup_error("{"), "cut.mrk.json: expected JSON of 3D Slicer's Markups, found other text");
  EXPECT_EQ(markup_error("{}"), "cut.mrk.json: markups: expected a list, found nothing");
  EXPECT_NE(markup_error(markups_text("Fiducial", kThree)).find("expected one Line"), std::string::npos);
  EXPECT_NE(markup_error(markups_text("Line", kThree)).find("expected the 2 points of a line, found 3"),
            std::string::npos);
  EXPECT_NE(markup_error(markups_text("Curve", point("[1, 2, 3]"))).find("2 points or more"),
            std::string::npos);
  EXPECT_NE(
      markup_error(markups_text("Curve", kThree + "," + point("[1, \"a\", 3]"))).find("controlPoints[3]"),
      std::string::npos);
  EXPECT_NE(markup_error(markups_text("Curve", kThree, "XYZ")).find("coordinateSystem"), std::string::npos);
  EXPECT_NE(markup_error(markups_text("Curve", kThree, "LPS", "\"furlong\"")).find("coordinateUnits"),
            std::string::npos);
}

constexpr const char* kCutScene = R"([world]
[body.torso]
model = "lattice"
ct = { phantom = "torso" }
[incision.midline]
body = "torso"
)";

// A scene takes a cut from a file beside it, and --set replaces a cut of the scene.
TEST(Markups, SceneAndOverrideTakeCutFromFile) {
  const fs::path folder = test::fresh_folder();
  std::ofstream(folder / "cut.mrk.json") << markups_text("Curve", kThree);
  const Result<Scene> named =
      parse_scene(std::string(kCutScene) + "markups = \"cut.mrk.json\"\n", folder / "s.toml");
  ASSERT_TRUE(named) << named.error().message;
  ASSERT_EQ(named->incisions[0].blade.path.size(), 3u);
  EXPECT_LT(norm(named->incisions[0].blade.from - Vec3d{0.01, -0.02, 0.03}), 1e-12);

  std::ofstream(folder / "line.mrk.json")
      << markups_text("Line", point("[10, -20, 30]") + "," + point("[40, -20, 30]"));
  const Result<Scene> replaced =
      parse_scene(std::string(kCutScene) + "path_fraction = [[0, 0, 0], [1, 1, 1], [1, 0, 0]]\n",
                  folder / "s.toml", {"incision.midline.markups=" + (folder / "line.mrk.json").string()});
  ASSERT_TRUE(replaced) << replaced.error().message;
  EXPECT_FALSE(replaced->incisions[0].by_fraction);
  EXPECT_TRUE(replaced->incisions[0].blade.path.empty());
  EXPECT_LT(norm(replaced->incisions[0].blade.to - Vec3d{0.04, -0.02, 0.03}), 1e-12);
}

// A missing file is an error at the key.
TEST(Markups, MissingFileIsReportedAtKey) {
  const Result<Scene> scene =
      parse_scene(std::string(kCutScene) + "markups = \"none.mrk.json\"\n", "/none/s.toml");
  ASSERT_FALSE(scene);
  EXPECT_NE(scene.error().message.find("s.toml:7:"), std::string::npos) << scene.error().message;
  EXPECT_NE(scene.error().message.find("none.mrk.json"), std::string::npos);
}

}  // namespace
}  // namespace turgor

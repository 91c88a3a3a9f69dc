#include "turgor/sim/report/plot.hpp"

#include <algorithm>
#include <clocale>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <sstream>

#include <gtest/gtest.h>
#include <pugixml.hpp>

#include "tests/folders.hpp"

namespace turgor {
namespace {

Plot two_curves() {
  Plot plot{"Force over depth", "depth [mm]", "force [N]", {{"given", {}}, {"chain", {}}}};
  for (int i = 0; i <= 20; i++) {
    plot.curves[0].points.emplace_back(0.5 * i, 0.01 * i * i);
    plot.curves[1].points.emplace_back(0.5 * i, 0.012 * i * i - 0.3);
  }
  return plot;
}

pugi::xml_document parsed(const std::string& svg) {
  pugi::xml_document document;
  const auto result = document.load_string(svg.c_str());
  EXPECT_TRUE(result) << result.description() << "\n" << svg;
  return document;
}

std::vector<std::string> texts(const pugi::xml_document& document) {
  std::vector<std::string> found;
  for (const pugi::xml_node text : document.child("svg").children("text"))
    found.push_back(text.child_value());
  return found;
}

// Bands mark intervals of the axis and are named once.
TEST(Plot, BandsAreNamedOnce) {
  Plot plot = two_curves();
  plot.bands = {{"over nodule", 2, 4}, {"over nodule", 8, 30}, {"over nothing", 11, 12}};
  const pugi::xml_document document = parsed(plot_svg(plot));
  std::vector<double> widths;
  for (const pugi::xml_node rect : document.child("svg").children("rect"))
    if (std::string(rect.attribute("class").value()) == "plot-band")
      widths.push_back(rect.attribute("width").as_double());
  ASSERT_EQ(widths.size(), 2u) << "bands off the axis are not drawn";
  EXPECT_NEAR(widths[1], widths[0], 0.2) << "up to the end of the axis at 10";
  const std::vector<std::string> words = texts(document);
  EXPECT_EQ(std::count(words.begin(), words.end(), "over nodule"), 1);
}

// A region is a closed path within the axes, which hold it, and has an entry in the legend.
TEST(Plot, RegionLiesWithinAxes) {
  Plot plot = two_curves();
  plot.region = {"band", {{0, -2, 1}, {5, 1, 3}, {std::nan(""), 0, 1}, {10, 3, 9}}};
  const pugi::xml_document document = parsed(plot_svg(plot));
  const pugi::xml_node area = document.child("svg").find_child_by_attribute("rect", "class", "plot-area");
  std::vector<std::string> paths;
  for (const pugi::xml_node path : document.child("svg").children("path"))
    if (std::string(path.attribute("class").value()) == "plot-band")
      paths.push_back(path.attribute("d").value());
  ASSERT_EQ(paths.size(), 2u) << "the mark of the legend and the region";
  std::istringstream in(paths[1]);
  const double top = area.attribute("y").as_double(), height = area.attribute("height").as_double();
  int count = 0;
  for (std::string point; std::getline(in, point, 'L'); count++) {
    const double y = std::strtod(point.c_str() + point.find(' '), nullptr);
    EXPECT_GE(y, top - 0.1);
    EXPECT_LE(y, top + height + 0.1);
  }
  EXPECT_EQ(count, 6) << "three points of each border";
  EXPECT_EQ(paths[1].back(), 'Z');
  const std::vector<std::string> words = texts(document);
  EXPECT_EQ(std::count(words.begin(), words.end(), "band"), 1);
}

// Titles, labels and ticks are text of at least eleven pixels.
TEST(Plot, TextIsAtLeastElevenPixels) {
  const pugi::xml_document document = parsed(plot_svg(two_curves()));
  const std::vector<std::string> found = texts(document);
  for (const char* text : {"Force over depth", "depth [mm]", "force [N]", "given", "chain", "0", "4", "10"})
    EXPECT_NE(std::find(found.begin(), found.end(), text), found.end()) << text;
  const pugi::xml_node svg = document.child("svg");
  constexpr double kNarrowest = 460;  // smallest width on the report's page [pixels]
  EXPECT_GE(svg.attribute("font-size").as_double() * kNarrowest / svg.attribute("width").as_double(), 11);
}

// Points lie at their values on the axes.
TEST(Plot, PointsFollowAxes) {
  const Plot line{"", "x", "y", {{"", {{0, 0}, {10, 5}, {20, 10}}}}};
  const pugi::xml_document document = parsed(plot_svg(line));
  std::vector<std::pair<double, double>> dots;
  for (const pugi::xml_node dot : document.child("svg").children("circle"))
    dots.emplace_back(dot.attribute("cx").as_double(), dot.attribute("cy").as_double());
  ASSERT_EQ(dots.size(), 3u);
  EXPECT_NEAR(dots[1].first, 0.5 * (dots[0].first + dots[2].first), 0.11);
  EXPECT_NEAR(dots[1].second, 0.5 * (dots[0].second + dots[2].second), 0.11);
  EXPECT_GT(dots[0].second, dots[2].second) << "larger values are higher";
}

// Labels are escaped text for any content.
TEST(Plot, LabelsAreEscaped) {
  Plot plot = two_curves();
  plot.title = "x'\nsystem(\"id\")\n#";
  plot.curves[0].label = "</text><script>alert(1)</script>\x01\xff";
  plot.x_label = "\"&<>'";
  const pugi::xml_document document = parsed(plot_svg(plot));
  EXPECT_FALSE(document.child("svg").child("script"));
  const std::vector<std::string> found = texts(document);
  EXPECT_NE(std::find(found.begin(), found.end(), "\"&<>'"), found.end());
  EXPECT_NE(std::find(found.begin(), found.end(), "</text><script>alert(1)</script>\uFFFD\uFFFD"),
            found.end());
}

// A plot starts no external program.
TEST(Plot, StartsNoProgram) {
  const std::filesystem::path folder = test::fresh_folder();
  test::write(folder / "gnuplot", "#!/bin/sh\ntouch '" + (folder / "ran").string() + "'\n");
  std::filesystem::permissions(folder / "gnuplot", std::filesystem::perms::owner_all);
  const std::string path = std::getenv("PATH");
  setenv("PATH", (folder.string() + ":" + path).c_str(), 1);
  EXPECT_NE(plot_svg(two_curves()).find("<path d=\"M"), std::string::npos);
  setenv("PATH", path.c_str(), 1);
  EXPECT_FALSE(std::filesystem::exists(folder / "ran"));
}

// Values that cannot be drawn are omitted.
TEST(Plot, NonFiniteValuesAreOmitted) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(),
                   kInf = std::numeric_limits<double>::infinity();
  EXPECT_EQ(plot_svg({"t", "x", "y", {}}), "");
  EXPECT_EQ(plot_svg({"t", "x", "y", {{"c", {{kNan, 1}, {1, kInf}, {-kInf, 1}, {1e308, -1e308}}}}}), "");
  EXPECT_EQ(plot_svg({"t", "x", "y", {{"c", {{1, 0}, {2, -1}}}}, true}), "") << "no logarithm";
  for (const double far : {1e299, 1e-299, 5e-324, 1e16}) {
    const std::string svg =
        plot_svg({"t", "x", "y", {{"c", {{kNan, 1}, {far, far}, {far, -far}, {2 * far, far}}}}});
    parsed(svg);
    EXPECT_EQ(svg.find("nan"), std::string::npos) << far;
    EXPECT_EQ(svg.find("inf"), std::string::npos) << far;
    EXPECT_LT(svg.size(), 20000u) << far;
  }
  parsed(plot_svg({"t", "x", "y", {{"c", {{1, 1e16}, {2, 1e16 + 2}}}}}));
  parsed(plot_svg({"t", "x", "y", {{"c", {{3, 3}}}}}));
}

// Logarithmic axes have ticks at powers of ten.
TEST(Plot, LogAxisShowsPowersOfTen) {
  const std::vector<std::string> found =
      texts(parsed(plot_svg({"t", "x", "y", {{"c", {{0, 2e-3}, {1, 0.5}, {2, 30}}}}, true})));
  for (const char* text : {"10⁻³", "10⁻²", "10⁻¹", "10⁰", "10¹", "10²"})
    EXPECT_NE(std::find(found.begin(), found.end(), text), found.end()) << text;
}

// A plot of a million points is small and keeps the peaks.
TEST(Plot, DownsamplingKeepsPeaks) {
  Plot plot{"t", "x", "y", {{"c", {}}}};
  for (int i = 0; i < 1000000; i++) plot.curves[0].points.emplace_back(i, i == 123457 ? 9.0 : std::sin(i));
  const std::string svg = plot_svg(plot);
  EXPECT_LT(svg.size(), 40000u);
  double highest = 1e9;
  const std::string path = parsed(svg).child("svg").last_child().attribute("d").value();
  std::istringstream numbers(path);
  for (std::string point; std::getline(numbers, point, 'L');)
    highest = std::min(highest, std::stod(point.substr(point.find(' ') + 1)));
  Plot small{"t", "x", "y", {{"c", {{0, -1}, {123457, 9}, {999999, 1}}}}};
  const pugi::xml_document dots = parsed(plot_svg(small));
  const pugi::xml_node peak = dots.child("svg").child("circle").next_sibling("circle");
  EXPECT_NEAR(highest, peak.attribute("cy").as_double(), 1.5);
}

// The legend of many curves stays above them.
TEST(Plot, LegendStaysAboveCurves) {
  Plot plot{"t", "x", "y", {}};
  for (int c = 0; c < 60; c++)
    plot.curves.push_back({"a curve with a name " + std::to_string(c), {{0, 0}, {1, c}}});
  const pugi::xml_document document = parsed(plot_svg(plot));
  const double lowest_grid = document.child("svg").attribute("height").as_double();
  for (const pugi::xml_node text : document.child("svg").children("text"))
    EXPECT_LT(text.attribute("y").as_double(), lowest_grid);
}

// Numbers do not depend on the locale.
TEST(Plot, NumbersIgnoreLocale) {
  const std::string before = plot_svg(two_curves());
  for (const char* name : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8"}) std::setlocale(LC_ALL, name);
  EXPECT_EQ(plot_svg(two_curves()), before);
  std::setlocale(LC_ALL, "C");
}

}  // namespace
}  // namespace turgor

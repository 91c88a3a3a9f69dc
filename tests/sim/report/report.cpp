#include "turgor/sim/report/report.hpp"

#include "tests/sim/block_scene.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/io/files/image.hpp"
#include "turgor/sim/report/summary.hpp"

namespace turgor {
namespace {

struct BlockRun {
  std::filesystem::path folder = test::fresh_folder();
  Json report;
};

/// A short run of the block with one picture.
BlockRun block_run() {
  BlockRun run;
  const Exec exec(1);
  const Scene scene =
      test::block_scene(run.folder, {"output.window=bone", "body.block.skin.tension=[60, 30]"});
  World world = test::block_world(exec, scene);
  Measures measures = make_measures(world);
  for (int frame = 1; frame <= 10; frame++)
    measure_frame(exec, world, step(exec, world, true).value(), true, measures);
  RunFacts facts;
  facts.simulation_seconds = 1.25, facts.drawing_seconds = 1.75;
  run.report = simulation_report(exec, scene, world, measures, facts);
  EXPECT_TRUE(write_png(run.folder / "a.png", make_image(8, 8, {255, 0, 0})));
  facts.pictures = {{"a.png", "red <square>", false}};
  facts.warnings = {"something & else"};
  facts.deformed = {{"block", "d.nii", {1, 2, 3}, 0.5, 0.01, 0}};
  add_outputs(run.report, facts);
  EXPECT_EQ(run.report["bodies"][0]["state_hash"],
            hash_text(lattice::state_hash(world.lattice_bodies[0].model, world.lattice_bodies[0].state)));
  return run;
}

// The report has the measures of a run with their units.
TEST(Report, HasMeasuresWithUnits) {
  const Json report = block_run().report;
  EXPECT_EQ(report["scene"]["overrides"][0], "output.window=bone");
  EXPECT_EQ(report["bodies"][0]["lattice_spacing_mm"], Json::array({8.0, 8.0, 8.0}));
  EXPECT_GT(report["bodies"][0]["body_nodes"].get<int>(), 1000);
  const Json& wound = report["wounds"][0];
  EXPECT_EQ(wound["name"], "cut");
  EXPECT_GT(wound["gape_max_mm"].get<double>(), 0.1);
  EXPECT_EQ(wound["series"].size(), 8u);
  EXPECT_EQ(wound["series"][7][1], wound["gape_max_mm"]);
  EXPECT_NEAR(wound["angle_to_lines_deg"].get<double>(), 90, 0.1);
  EXPECT_EQ(report["timing"]["frames"], 10);
  EXPECT_EQ(report["timing"]["simulation_s"], 1.25);
  EXPECT_EQ(report["state_hash"].get<std::string>().size(), 16u);
  EXPECT_EQ(report["warnings"][0], "something & else");
  EXPECT_EQ(Json::parse(report.dump()), report);
}

// The bytes of the fields of a body are together its memory.
TEST(Report, FieldsHaveBytesOfBody) {
  const Json body = block_run().report["bodies"][0];
  std::size_t sum = 0;
  for (const auto& bytes : body["memory_bytes_by_field"]) sum += bytes.get<std::size_t>();
  EXPECT_EQ(sum, body["memory_bytes"].get<std::size_t>());
}

// Skin whose tension is equal both ways has no angle to Langer's lines.
TEST(Report, EqualTensionHasNoAngle) {
  const Exec exec(1);
  const Scene scene = test::block_scene(test::fresh_folder());
  World world = test::block_world(exec, scene);
  Measures measures = make_measures(world);
  for (int frame = 1; frame <= 10; frame++)
    measure_frame(exec, world, step(exec, world, true).value(), true, measures);
  const Json wound = simulation_report(exec, scene, world, measures, {})["wounds"][0];
  EXPECT_FALSE(wound.contains("angle_to_lines_deg"));
  EXPECT_NEAR(wound["tension_across_cut_N_per_m"].get<double>(), 45, 1e-9);
}

// The page begins with the verdict; times are at its end; quantities without a value have no card.
TEST(Report, PageBeginsWithVerdictAndEndsWithTime) {
  BlockRun run = block_run();
  run.report["tools"] = {{{"name", "finger"}, {"tick_p50_us", Json()}, {"force_max_N", 1.5}}};
  const std::string html = report_html(run.report, run.folder);
  const auto at = [&html](const char* text) { return html.find(text); };
  ASSERT_NE(at("<p class=\"verdict\">The wound"), std::string::npos);
  EXPECT_LT(at("class=\"verdict\""), at("class=\"warning\""));
  EXPECT_LT(at("class=\"warning\""), at("<h2>Measures</h2>"));
  EXPECT_LT(at("<h2>Measures</h2>"), at("<h2>Parameters</h2>"));
  EXPECT_LT(at("<h2>Parameters</h2>"), at("<h2>Solver</h2>"));
  EXPECT_LT(at("<h2>Solver</h2>"), at("<h2>Time</h2>"));
  EXPECT_LT(at("<h2>Time</h2>"), at("frame (median)"));
  for (const char* row : {"<td>reading and building [s]</td>", "<td>physics [s]</td>", "<td>drawing [s]</td>",
                          "<td>writing files [s]</td>", "<td>total [s]</td>"})
    EXPECT_LT(at("<h2>Time</h2>"), at(row)) << row;
  EXPECT_NE(at("largest force on finger"), std::string::npos);
  EXPECT_EQ(at("time per force of finger"), std::string::npos);
  EXPECT_NE(at("body.block.skin.tension"), std::string::npos);
  EXPECT_NE(at("@page { size: A4;"), std::string::npos);
}

// The page names the patient, the study, the series and the day of the CT; a phantom has its own words.
TEST(Report, PageNamesPatientSeriesAndDate) {
  const Exec exec(1);
  const std::filesystem::path folder = test::fresh_folder();
  const Scene scene = test::block_scene(folder);
  World world = test::block_world(exec, scene);
  LatticeBody& body = world.lattice_bodies[0];
  body.ct_origin.elements = {
      {0x00100010, "DOE^JANE "}, {0x00100020, "17"}, {0x00081030, "Thorax <1>"}, {0x00080020, "20240501"}};
  body.ct_series = "B30f";
  Json report = simulation_report(exec, scene, world, make_measures(world), {});
  add_outputs(report, {});
  EXPECT_NE(report_html(report, folder)
                .find("block: patient DOE^JANE (17), Thorax &lt;1&gt;, series &#39;B30f&#39;, scanned "
                      "2024-05-01</p>"),
            std::string::npos);
  report["bodies"][0]["ct"] = {{"source", "phantom"}};
  EXPECT_NE(report_html(report, folder).find("block: a synthetic CT</p>"), std::string::npos);
}

// The table of tissues names law, values and source of every layer, in the report and on the page.
TEST(Report, TissuesNameLawAndSource) {
  const Exec exec(1);
  const Scene scene = test::block_scene(
      test::fresh_folder(),
      {"body.block.tissue.law=exponential",
       "body.block.layers=[{ name = \"dermis\", thickness = 0.004, young = 6e4, stiffening = 20 }, "
       "{ name = \"deep\", tissue = \"muscle-upper-arm\", law = \"solid\" }]"});
  World world = test::block_world(exec, scene);
  Json report = simulation_report(exec, scene, world, make_measures(world), {});
  add_outputs(report, {});
  const auto row_of = [&](const std::string& name) {
    for (const Json& row : report["tissues"])
      if (row["name"] == "block: layer " + name) return row;
    return Json();
  };
  const Json dermis = row_of("dermis"), deep = row_of("deep");
  ASSERT_TRUE(dermis.is_object() && deep.is_object()) << report["tissues"].dump(1);
  EXPECT_EQ(dermis["law"], "exponential");
  EXPECT_NE(dermis["values"].get<std::string>().find("young 60 kPa"), std::string::npos) << dermis;
  EXPECT_EQ(deep["law"], "solid");
  EXPECT_NE(deep["source"].get<std::string>().find("muscle-upper-arm"), std::string::npos) << deep;
  const std::string html = report_html(report, {});
  const std::size_t table = html.find("<h2>Tissues</h2>");
  ASSERT_NE(table, std::string::npos);
  for (const Json& row : {dermis, deep})
    for (const char* column : {"name", "law", "values"})
      EXPECT_NE(html.find(row[column].get<std::string>(), table), std::string::npos) << row[column];
}

// Without measures of wounds or cloth no half of the page is empty: the parameters follow the tables.
TEST(Report, ParametersFollowTablesWithoutMeasures) {
  BlockRun run = block_run();
  run.report["wounds"] = Json::array();
  run.report["skin"] = Json::array();
  const std::string html = report_html(run.report, run.folder);
  EXPECT_EQ(html.find("<div class=\"beside\">"), html.npos);
  EXPECT_LT(html.find("<h2>Lattices</h2>"), html.find("<h2>Parameters</h2>"));
  EXPECT_NE(html.find("<h2>Parameters</h2>"), html.npos);
}

// The expected error of a gape grows with the square of spacing over depth: 8 mm over 24 mm here.
TEST(Report, GapeErrorFollowsSpacing) {
  const Scene scene = test::block_scene(test::fresh_folder());
  const World world = test::block_world(Exec(1), scene);
  const lattice::Model& model = world.lattice_bodies[0].model;
  EXPECT_NEAR(expected_gape_error(model, 0.024), 0.94 / 9, 1e-6);
  EXPECT_NEAR(expected_gape_error(model, 0.048), 0.94 / 36, 1e-6);
  EXPECT_LT(expected_gape_error(model, 0.012), 0) << "fewer than two spacings of depth";
}

// The page is one file that embeds its pictures and curves.
TEST(Report, PageIsSelfContained) {
  const BlockRun run = block_run();
  const std::string html = report_html(run.report, run.folder);
  EXPECT_NE(html.find("src=\"data:image/png;base64,iVBORw0KGgo"),
            std::string::npos);  // signature of every PNG
  EXPECT_NE(html.find("red &lt;square&gt;"), std::string::npos);
  EXPECT_NE(html.find("something &amp; else"), std::string::npos);
  EXPECT_NE(html.find("gape, largest [mm]"), std::string::npos);
  EXPECT_NE(html.find("Gape over time"), std::string::npos);
  EXPECT_NE(html.find("prefers-color-scheme: dark"), std::string::npos);
  EXPECT_EQ(html.find("src=\"http"), std::string::npos);
  EXPECT_EQ(html.find("href=\"http"), std::string::npos);
  EXPECT_EQ(html.find("url(http"), std::string::npos);
}

// The summary for the terminal has the measures of the page.
TEST(Report, SummaryMatchesPage) {
  const BlockRun run = block_run();
  const std::string text = summary_text(run.report, "out/block");
  EXPECT_NE(text.find("cut\n  angle to Langer's lines           90.0°\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\n  gape, largest                     "), std::string::npos) << text;
  EXPECT_NE(text.find("\n  physics                           "), std::string::npos) << text;
  EXPECT_NE(text.find("\n  drawing                           1.75 s\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\nwarning: something & else\n"), std::string::npos) << text;
  EXPECT_NE(text.find("out/block/report.html\n"), std::string::npos) << text;
}

// A command that draws the recording names its folder.
TEST(Report, SummaryNamesRecordingInItsFolder) {
  BlockRun run = block_run();
  run.report["more_pictures"] = "turgor run --replay recording.h5 --set output.pictures=all";
  EXPECT_NE(summary_text(run.report, "out/block").find("--replay out/block/recording.h5 --set"),
            std::string::npos);
}

// The report has the solver of every lattice.
TEST(Report, EveryLatticeHasOwnSolver) {
  const std::filesystem::path folder = test::fresh_folder();
  ASSERT_TRUE(write_ct(folder / "block.nii", test::block_ct()));
  const Result<Scene> scene = parse_scene(
      "[body.one]\nmodel = \"lattice\"\nct = \"block.nii\"\nblock = 4\nsolver = { sweeps = 3 }\n"
      "[body.two]\nmodel = \"lattice\"\nct = \"block.nii\"\nblock = 4\nskin = { law = \"area\" }\n"
      "solver = { method = \"pbd\", sweeps = 7 }\n",
      folder / "s.toml");
  ASSERT_TRUE(scene) << scene.error().message;
  const Exec exec(1);
  const World world = test::block_world(exec, *scene);
  const Json report = simulation_report(exec, *scene, world, make_measures(world), {});
  EXPECT_EQ(report["bodies"][0]["method"], "vbd");
  EXPECT_EQ(report["bodies"][0]["sweeps"], 3);
  EXPECT_EQ(report["bodies"][1]["method"], "pbd");
  EXPECT_EQ(report["bodies"][1]["sweeps"], 7);
  EXPECT_FALSE(report["scene"].contains("method"));
}

/// Text that would be a tag, end an attribute or start a program if it were not escaped.
const std::string kEvil = "\"><script>alert('1')</script>\nsystem(\"id\")\n#\x1b[31m\xff";

/// Replaces every text of the report except those that name files and columns; numbers are kept.
void poison(Json& node) {
  if (node.is_string()) node = kEvil;
  if (node.is_structured())
    for (auto& [key, value] : node.items())
      if (key != "pictures" && !key.ends_with("columns")) poison(value);
}

// Texts of the scene and of files are escaped on the page.
TEST(Report, TextsAreEscapedOnPage) {
  BlockRun run = block_run();
  Json& report = run.report;
  report["pictures"][0]["caption"] = kEvil;
  report["tools"] = {{{"name", kEvil},
                      {"body", kEvil},
                      {"shape", kEvil},
                      {"friction", 0.1},
                      {"force_max_N", 1},
                      {"depth_max_mm", 2},
                      {"tick_p50_us", 1.0},
                      {"tick_p99_us", 1.0},
                      {"series_columns", {"time_s", "force_N", "depth_mm", "path_mm", "contacts"}},
                      {"series", Json::array({{0, 1, 1, 0, 1}, {1, 2, 2, 1, 1}})}}};
  const Json row = Json::array({0.0, 1.0, 2.0, 3.0}), rows = Json::array({row, row});
  report["profiles"] = {{{"name", kEvil}, {"columns", {"distance_mm", "displacement_mm"}}, {"rows", rows}}};
  const Json entry = {{"name", kEvil},  {"cloth", kEvil},
                      {"kind", kEvil},  {"series_columns", {"time_s", "force_N"}},
                      {"series", rows}, {"vertices", 3}};
  report["bodies"] = {{{"name", kEvil},
                       {"model", "cloth"},
                       {"step_p50_ms", 1},
                       {"triangles_crossing", 0},
                       {"method", kEvil},
                       {"series_columns", {"time_s", "step_ms", "largest_speed_m_per_s", "contacts"}},
                       {"series", rows},
                       {"snapshot_columns", {"time_s", "residual_relative", "energy_J"}},
                       {"snapshots", rows},
                       {"obstacles", {entry}},
                       {"holds", {entry}}}};
  report["bodies"].push_back({{"name", kEvil}, {"model", "rhombus"}, {"source", kEvil}, {"tissue", kEvil}});
  poison(report);
  report["bodies"][0]["model"] = "cloth",
  report["bodies"][1]["model"] = "rhombus";  // otherwise the page omits them
  const std::string html = report_html(report, run.folder);
  EXPECT_EQ(html.find("<script"), html.rfind("<script")) << "only the script of the page";
  EXPECT_EQ(html.find("<script"), html.find("<script>\nfor (const plot"));
  EXPECT_EQ(html.find("alert('"), std::string::npos);
  EXPECT_EQ(html.find('\x1b'), std::string::npos);
  EXPECT_EQ(html.find('\xff'), std::string::npos);
  EXPECT_NE(html.find("\" >&quot;&gt;&lt;script&gt;alert(&#39;1&#39;)"), std::string::npos)
      << "label of a curve";
  EXPECT_NE(html.find("alt=\"&quot;&gt;&lt;script"), std::string::npos) << "caption of a picture";
  EXPECT_EQ(Json::parse(json_text(report)).size(), report.size()) << "JSON accepts invalid UTF-8";
}

}  // namespace
}  // namespace turgor

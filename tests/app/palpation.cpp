// Runs of SFEM bodies and tools: the files that a run writes, and the messages for wrong inputs.
#include "tests/app/program.hpp"
#include "tests/sim/sfem_scene_text.hpp"
#include "turgor/io/mesh/surface_files.hpp"

namespace turgor {
namespace {

using nlohmann::json;
using namespace test;

const char* kCache = "cache = \"kept\"\n";

// A run writes forces, pictures, meshes, a recording and a report.
TEST(Palpation, RunWritesAllOutputs) {
  const fs::path folder = fresh_folder();
  write(folder / "s.toml", sfem_scene_text());
  const Ended ended =
      run_program("run s.toml --out out --set output.pictures=all --set body.pad.cache=kept", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  EXPECT_NE(ended.printed.find("pad: 324 free nodes; Green's functions between"), std::string::npos)
      << ended.printed;
  EXPECT_NE(ended.printed.find("largest force"), std::string::npos);
  for (const char* name :
       {"report.json", "report.html", "recording.h5", "forces.csv", "pad.obj", "meshes.pvd",
        "meshes/pad-0000.vtu", "meshes/tools/finger-0030.vtu", "meshes/forces/on-tools-0030.vtu",
        "meshes/pad-0030.vtu", "pad-near.png", "pad-whole.png", "pad-displacement.png", "pad-pressure.png"})
    EXPECT_TRUE(fs::exists(folder / "out" / name)) << name;
  const json report = report_in(folder / "out");
  EXPECT_GT(report["tools"][0]["force_max_N"].get<double>(), 0.05);
  EXPECT_FALSE(report["bodies"][0]["green"]["from_cache"].get<bool>());
  EXPECT_EQ(report["bodies"].size(), 1u);
  EXPECT_EQ(report["bodies"][0]["model"], "sfem");
}

// A scene that chooses a cache outside the user's folder is refused, and no folder is made.
TEST(Palpation, SceneChoosesNoForeignCache) {
  const fs::path folder = fresh_folder();
  write(folder / "s.toml", sfem_scene_text("cache = \"" + (folder / "foreign").string() + "\"\n"));
  const Ended ended = run_program("run s.toml -q --out out", folder);
  EXPECT_EQ(ended.code, 2) << ended.printed;
  EXPECT_NE(ended.printed.find("body.pad.cache: expected a folder below the user's cache folder"),
            std::string::npos)
      << ended.printed;
  EXPECT_EQ(names_in(folder).size(), 1u) << "the scene only";
}

// With little memory OpenGL fails, and the run keeps its results: only pictures are missing, with a warning.
TEST(Palpation, LittleMemoryCostsOnlyPictures) {
  const fs::path folder = fresh_folder();
  write(folder / "s.toml", sfem_scene_text("cache = false\n"));
  int without_pictures = 0;
  for (const char* kilobytes : {"350000", "400000", "450000", "500000", "600000"}) {
    const Ended ended = run_program("run s.toml -q --threads 1 --force --out out", folder,
                                    std::string("ulimit -v ") + kilobytes);
    ASSERT_EQ(ended.code, 0) << kilobytes << " kB: " << ended.printed;
    const json report = report_in(folder / "out");
    EXPECT_GT(report["tools"][0]["force_max_N"].get<double>(), 0.05);
    EXPECT_TRUE(fs::exists(folder / "out" / "recording.h5") && fs::exists(folder / "out" / "forces.csv"));
    const bool warns =
        report["warnings"].dump().find("no pictures of surfaces: cannot draw") != std::string::npos;
    EXPECT_EQ(warns, !fs::exists(folder / "out" / "pad-near.png"))
        << kilobytes << " kB: " << report["warnings"];
    without_pictures += warns;
  }
  EXPECT_GT(without_pictures, 0) << "expected a limit below the need of OpenGL";
}

// With few processes the run keeps its results too; it starts fewer threads and no process that draws. The
// limit does not hold for root, who runs it as a user without processes.
TEST(Palpation, FewProcessesCostOnlyPictures) {
  const fs::path folder = fresh_folder();
  write(folder / "s.toml", sfem_scene_text("cache = false\n"));
  std::string user;
  if (geteuid() == 0) {
    user = "setpriv --reuid=61234 --regid=61234 --clear-groups ";
    fs::permissions(folder, fs::perms::all);
    if (run_shell(user + "test -x '" TURGOR_PROGRAM "'", folder).code != 0)
      GTEST_SKIP() << "root cannot run the program as another user";
  }
  const Ended ended =
      run_shell(user + "prlimit --nproc=1 '" TURGOR_PROGRAM "' run s.toml -q --threads 8 --out out", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  const json report = report_in(folder / "out");
  EXPECT_GT(report["tools"][0]["force_max_N"].get<double>(), 0.05);
  EXPECT_NE(report["warnings"].dump().find("no pictures of surfaces: cannot draw"), std::string::npos)
      << report["warnings"];
}

// Surfaces in millimeters and RAS coordinates equal those in meters and LPS.
TEST(Palpation, MillimetersAndRasKeepSurface) {
  const fs::path folder = fresh_folder();
  write(folder / "s.toml", sfem_scene_text(kCache));
  ASSERT_EQ(run_program("run s.toml -q --out meters", folder).code, 0);
  const Ended ended = run_program(
      "run --replay meters/recording.h5 --out mm --set output.mesh_unit=mm --set output.mesh_frame=RAS",
      folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  const Result<ReadSurface> meters = read_surface(folder / "meters" / "pad.obj"),
                            turned = read_surface(folder / "mm" / "pad.obj", 0.001);
  ASSERT_TRUE(meters && turned);
  EXPECT_EQ(meters->mesh.triangles, turned->mesh.triangles);
  for (std::size_t v = 0; v < meters->mesh.vertices.size(); v++) {
    const Vec3 a = meters->mesh.vertices[v], b = turned->mesh.vertices[v];
    ASSERT_NEAR(norm(a - Vec3{-b.x, -b.y, b.z}), 0, 1e-8) << v;
  }
  const std::string vtu = bytes_of(folder / "mm" / "meshes" / "pad-0030.vtu");
  EXPECT_NE(vtu.find("Name=\"displacement [mm]\""), std::string::npos);
  EXPECT_NE(vtu.find("Name=\"pressure [Pa]\""), std::string::npos);
  EXPECT_NE(bytes_of(folder / "mm" / "meshes.pvd").find("millimeters, patient frame RAS"), std::string::npos);
}

// A replay writes the same pictures, tables and meshes as the run.
TEST(Palpation, ReplayWritesEqualFiles) {
  const fs::path folder = fresh_folder();
  write(folder / "s.toml", sfem_scene_text(kCache));
  ASSERT_EQ(run_program("run s.toml -q --out first", folder).code, 0);
  const Ended ended = run_program("run --replay first/recording.h5 --out again", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  for (const auto& entry : fs::recursive_directory_iterator(folder / "first")) {
    const fs::path name = fs::relative(entry.path(), folder / "first");
    if (name.extension() == ".png" || name.extension() == ".csv" || name.extension() == ".vtu") {
      EXPECT_TRUE(bytes_of(entry.path()) == bytes_of(folder / "again" / name)) << name;
    }
  }
  EXPECT_EQ(report_in(folder / "first")["tools"], report_in(folder / "again")["tools"]);
}

// A damaged cache file is named and recomputed, with the same final state.
TEST(Palpation, RecomputesDamagedCache) {
  const fs::path folder = fresh_folder();
  write(folder / "s.toml", sfem_scene_text(kCache));
  ASSERT_EQ(run_program("run s.toml -q --out first", folder).code, 0);
  const fs::path cache = report_in(folder / "first")["bodies"][0]["green"]["cache_file"].get<std::string>();
  write(cache, "no");
  const Ended ended = run_program("run s.toml --out again", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  EXPECT_NE(ended.printed.find("expected an HDF5 file, found something else; recomputed"), std::string::npos)
      << ended.printed;
  EXPECT_EQ(report_in(folder / "first")["state_hash"], report_in(folder / "again")["state_hash"]);
}

// The liver of the phantom is meshed from its label within 2 % of its volume.
TEST(Palpation, MeshesLabelOfPhantom) {
  const fs::path folder = fresh_folder();
  const std::string scene = std::string(TURGOR_SOURCE_DIR) + "/scenes/palpation.toml";
  const Ended ended = run_program("run '" + scene +
                                      "' --out out --set 'body.liver.labels={ phantom = \"torso\", size = "
                                      "[96, 96, 60], spacing_mm = [4.2, "
                                      "4.2, 5] }' --set body.liver.resolution=0.024 --set world.duration=0.4 "
                                      "--set output.video=false --set "
                                      "body.liver.cache=kept --set output.snapshots.size=[200,160]",
                                  folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  const json body = report_in(folder / "out")["bodies"][0];
  EXPECT_LT(std::abs(body["mesh"]["volume_error_percent"].get<double>()), 2);
  EXPECT_GT(body["mesh"]["min_dihedral_deg"].get<double>(), 10.7);
}

// The scene of the phantom also presses an organ of a real segmentation.
TEST(Palpation, PressesRealOrgan) {
  const fs::path labels = fs::path(TURGOR_SOURCE_DIR) / "../shared/data/ct/abdomen-slab-labels.nii.gz";
  if (!fs::exists(labels)) GTEST_SKIP() << "no " << labels;
  const fs::path folder = fresh_folder();
  const std::string scene = std::string(TURGOR_SOURCE_DIR) + "/scenes/palpation.toml";
  const Ended ended = run_program(
      "run '" + scene + "' --out out --set 'body.liver.labels=" + labels.string() +
          "' --set body.liver.inside={} --set body.liver.resolution=0.015 --set world.duration=0.7 "
          "--set body.liver.elements=linear --set output.video=false --set body.liver.cache=false",
      folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  const json report = report_in(folder / "out");
  EXPECT_NEAR(report["bodies"][0]["mesh"]["volume_ml"].get<double>(), 1043, 21);
  EXPECT_GT(report["tools"][0]["force_max_N"].get<double>(), 0.05);
  EXPECT_LT(report["tools"][0]["force_max_N"].get<double>(), 2);
  const Ended wrong = run_program("run '" + scene + "' --out o2 --set 'body.liver.labels=" + labels.string() +
                                      "' --set body.liver.inside={} --set body.liver.label=60000",
                                  folder);
  EXPECT_EQ(wrong.code, 2);
  EXPECT_NE(wrong.printed.find("label 60000 is not in the segmentation; it has 1 (255 mL)"),
            std::string::npos)
      << wrong.printed;
}

// The expected error of the mesh of the force covers the difference of two meshes and is smaller on the
// finer one.
TEST(Palpation, ErrorEstimateShrinksWithMesh) {
  const fs::path folder = fresh_folder();
  write(folder / "s.toml", sfem_scene_text("cache = false\n"));
  std::vector<double> expected_error, force;
  for (const char* count : {"[6,6,3]", "[12,12,6]"}) {
    const Ended ended =
        run_program(std::string("run s.toml --force --out out --set body.pad.block.count=") + count, folder);
    ASSERT_EQ(ended.code, 0) << ended.printed;
    EXPECT_NE(ended.printed.find("expected error of the mesh"), std::string::npos) << ended.printed;
    EXPECT_NE(bytes_of(folder / "out" / "report.html").find("expected error of the mesh"), std::string::npos);
    const json tool = report_in(folder / "out")["tools"][0];
    expected_error.push_back(tool["force_error_expected_percent"]), force.push_back(tool["force_max_N"]);
  }
  EXPECT_LT(expected_error[1], 0.4 * expected_error[0]);
  EXPECT_LE(100 * std::abs(force[0] / force[1] - 1), expected_error[0] + expected_error[1]);
  EXPECT_LT(expected_error[1], 20);
}

/// A tetrahedron file in Gmsh's format 2.2.
std::string gmsh(const std::string& nodes, int node_count, const std::string& elements, int element_count) {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" + std::to_string(node_count) + "\n" + nodes +
         "$EndNodes\n$Elements\n" + std::to_string(element_count) + "\n" + elements + "$EndElements\n";
}

// Wrong meshes, labels, keys and paths end with a message that names the mistake.
TEST(Palpation, WrongInputsEndWithMessage) {
  const fs::path folder = fresh_folder();
  write(folder / "good.toml", sfem_scene_text("cache = false\n"));
  write(folder / "flat.msh", gmsh("1 0 0 0\n2 1 0 0\n3 0 1 0\n4 1 1 0\n", 4, "1 4 2 1 1 1 2 3 4\n", 1));
  write(folder / "parts.msh",
        gmsh("1 0 0 0\n2 .1 0 0\n3 0 .1 0\n4 0 0 .1\n5 1 0 1\n6 1.1 0 1\n7 1 .1 1\n8 1 0 1.1\n", 8,
             "1 4 2 1 1 1 2 3 4\n2 4 2 1 1 5 6 7 8\n", 2));
  write(folder / "nan.csv", "t,x,y,z\n0,0,0,0\n1,nan,0,0\n");
  write(folder / "back.csv", "0,0,0,0\n1,0,0,0\n0.5,0,0,0\n");
  const auto with_mesh = [&](const char* name, const char* mesh, const char* fixed) {
    std::string text = sfem_scene_text("cache = false\n");
    const std::string block = "block = { size = [0.06, 0.06, 0.03], count = [8, 8, 4] }\nfixed = \"bottom\"";
    text.replace(text.find(block), block.size(), std::string("mesh = \"") + mesh + "\"\nfixed = " + fixed);
    write(folder / name, text);
  };
  with_mesh("flat.toml", "flat.msh", "\"bottom\"");
  with_mesh("parts.toml", "parts.msh", "{ box = [[-1, -1, -1], [0.2, 0.2, 0.2]] }");
  with_mesh("gone.toml", "gone.msh", "\"bottom\"");
  std::string labels = sfem_scene_text("cache = false\n");
  const std::string block = "block = { size = [0.06, 0.06, 0.03], count = [8, 8, 4] }\n";
  labels.replace(
      labels.find(block), block.size(),
      "labels = { phantom = \"torso\", size = [48, 48, 30], spacing_mm = [8, 8, 10] }\nlabel = 99\n");
  write(folder / "label.toml", labels);
  const struct {
    std::string arguments, words;
  } cases[] = {
      {"good.toml --set 'body.pad.fixed={ box = [[9, 9, 9], [10, 10, 10]] }'", "fixed"},
      {"parts.toml", "part"},
      {"flat.toml", "flat.msh"},
      {"gone.toml", "gone.msh"},
      {"good.toml --set body.pad.poisson=0.5", "--set body.pad.poisson: expected below 0.5"},
      {"good.toml --set body.pad.young=-3", "expected a number from 0.001 to 1e+12 [Pa], found -3"},
      {"label.toml", "99"},
      {"good.toml --set tool.finger.shape.sphere=0.4", "the tool is 0.8 m wide, the body pad 0.06 m"},
      {"good.toml --set tool.finger.body=paddy",
       "the scene has no body paddy with model = \"sfem\", \"rhombus\", \"lattice\", "
       "\"cloth\" or \"rigid\"; did you mean pad?"},
      {"good.toml --set tool.finger.press=false --set tool.finger.path=nan.csv", "not both"},
  };
  for (const auto& c : cases) {
    const Ended ended = run_program("run --out o " + c.arguments, folder);
    EXPECT_EQ(ended.code, 2) << c.arguments << "\n" << ended.printed;
    EXPECT_TRUE(has_error_line(ended.printed)) << ended.printed;
    EXPECT_NE(ended.printed.find(c.words), std::string::npos)
        << c.arguments << "\nprinted:  " << ended.printed << "expected: " << c.words;
    EXPECT_FALSE(fs::exists(folder / "o")) << c.arguments;
  }
  std::string path = sfem_scene_text("cache = false\n");
  path.replace(path.find("press = {"), path.find("slide = 0.15 }") + 14 - path.find("press = {"),
               "path = \"nan.csv\"");
  write(folder / "path.toml", path);
  EXPECT_NE(
      run_program("run --out o path.toml", folder).printed.find("nan.csv:3: expected numbers t, x, y, z"),
      std::string::npos);
  const Ended back = run_program("run --out o path.toml --set tool.finger.path=back.csv", folder);
  EXPECT_EQ(back.code, 2);
  EXPECT_NE(back.printed.find("back.csv: row 3 of the path: expected a time after that of the previous row"),
            std::string::npos)
      << back.printed;
}

// `bench sfem` writes its figures as JSON, including the plate of the paper.
TEST(Palpation, BenchSfemWritesJson) {
  const fs::path folder = fresh_folder();
  const Ended ended = run_program("bench sfem --largest 1000 --json b.json", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  std::ifstream stream(folder / "b.json");
  const json bench = json::parse(stream);
  EXPECT_EQ(bench["patches"][1]["local_nodes"], 98) << "the paper's plate, r = 3";
  EXPECT_EQ(bench["patches"][2]["local_nodes"], 243);
  EXPECT_EQ(bench["ticks"].size(), 6u);
  EXPECT_GT(bench["ticks"][5]["contacts"].get<int>(), bench["ticks"][0]["contacts"].get<int>());
  EXPECT_EQ(bench["precompute"].size(), 1u);
  EXPECT_EQ(bench["surface"]["vertices"], 5100);
}

}  // namespace
}  // namespace turgor

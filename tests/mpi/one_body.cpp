// One body in several MPI processes has, bit for bit, the state of the same body in one process without MPI.
// Errors are one message for all processes.
#include <cmath>
#include <filesystem>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "mpi/scene.hpp"
#include "tests/folders.hpp"
#include "tests/shell.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/io/ct.hpp"
#include "turgor/sim/run.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using test::Ended;

/// A torso of 25 layers of nodes, 12 mm apart: 7 pairs of slabs. One cut of 0.12 m runs along it, through
/// layers that any two, three or four processes share; a second one crosses the first.
std::string scene_text(const std::string& body, const std::string& rest = "") {
  return "[world]\nduration = 0.16\nframe_rate = 50\n[body.torso]\nmodel = \"lattice\"\n"
         "ct = { phantom = \"torso\", size = [72, 56, 48], spacing_mm = [6, 6, 6] }\nblock = 2\n"
         "fixed = [\"bone\", \"ends\"]\n" +
         body + "\n" + rest;
}
const std::string kAlong =
    "[incision.along]\nbody = \"torso\"\nfrom = [0.01, -0.12, 0.06]\nto = [0.01, -0.12, -0.06]\n"
    "depth = 0.03\nstart = 0.02\nduration = 0.06\n";
const std::string kAcross =
    "[incision.across]\nbody = \"torso\"\nfrom = [-0.05, -0.12, 0.003]\nto = [0.06, -0.12, 0.001]\n"
    "depth = 0.025\nstart = 0.1\n";
const std::string kSolid = "solver = { coarse = false, sweeps = 4 }";
const std::string kSprings = "solver = { sweeps = 3 }\ntissue = { law = \"springs\", volume = 1 }";
const std::string kProjections =
    "solver = { method = \"pbd\", pbd_volume = true }\nskin = { law = \"area\" }";

struct Folder {
  fs::path path = test::fresh_folder();

  explicit Folder(const std::string& scene) { test::write(path / "scene.toml", scene); }
};

struct Alone {
  World world;
  std::uint64_t hash = 0;
};
/// Runs the scene in this process.
Alone run_alone(const Folder& folder) {
  const Scene scene = read_scene(folder.path / "scene.toml").value();
  Alone alone{load_world(Exec(2), scene).value(), 0};
  for (int frame = 0; frame < frame_count(scene); frame++)
    EXPECT_TRUE(step(Exec(2), alone.world).value().finite);
  alone.hash = state_hash(alone.world);
  return alone;
}

Ended run_shared(const Folder& folder, int processes, const std::string& more = "") {
  return test::run_command(fmt::format("OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 "
                                       "OMPI_MCA_btl_vader_single_copy_mechanism=none "
                                       "'{}' -q --oversubscribe -n {} '{}' run scene.toml --out out {}",
                                       TURGOR_MPIRUN, processes, TURGOR_MPI_PROGRAM, more),
                           folder.path);
}
nlohmann::json report_of(const Folder& folder) {
  return nlohmann::json::parse(test::bytes_of(folder.path / "out" / "report.json"));
}

std::string words(Vec3d v) { return fmt::format("{} {} {}", v.x, v.y, v.z); }

/// Uncompressed: .nii of this library's writer, or .mhd with its samples in a second file.
void write_raw(const fs::path& path, const CtVolume& ct) {
  if (path.extension() == ".nii") return (void)write_ct(path, ct).value();
  const Grid& g = ct.grid;
  const fs::path raw = fs::path(path).replace_extension(".raw");
  test::write(
      path,
      fmt::format("ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
                  "CompressedData = False\nTransformMatrix = {} {} {}\nOffset = {}\nElementSpacing = {}\n"
                  "DimSize = {} {} {}\nElementType = MET_SHORT\nElementDataFile = {}\n",
                  words(g.axes.column[0]), words(g.axes.column[1]), words(g.axes.column[2]),
                  words(g.origin * 1e3), words(g.spacing * 1e3), g.size.x, g.size.y, g.size.z,
                  raw.filename().string()));
  const auto* bytes = reinterpret_cast<const char*>(ct.samples.data());
  test::write(raw, std::string(bytes, bytes + ct.samples.size() * sizeof ct.samples[0]));
}

void expect_the_same(const std::string& scene, std::initializer_list<int> processes) {
  const Folder folder(scene);
  const Alone alone = run_alone(folder);
  const lattice::State& state = alone.world.lattice_bodies[0].state;
  for (const int count : processes) {
    const Ended ended = run_shared(folder, count);
    ASSERT_EQ(ended.code, 0) << ended.printed;
    const nlohmann::json report = report_of(folder);
    EXPECT_EQ(report["state_hash"], hash_text(alone.hash)) << count << " processes";
    EXPECT_EQ(report["virtual_nodes"], state.motion.virtual_u.size());
    EXPECT_EQ(report["body_nodes"], alone.world.lattice_bodies[0].model.anatomy.body_nodes);
    EXPECT_EQ(report["free_nodes"], alone.world.lattice_bodies[0].model.anatomy.free_nodes);
    EXPECT_EQ(report["processes"].size(), std::size_t(count));
  }
}

}  // namespace

// Solid tissue with cuts across the slab borders reaches the state of one process.
TEST(OneBody, SolidTissue_EqualsOneProcess) {
  expect_the_same(scene_text(kSolid, kAlong + kAcross), {1, 2, 3, 4});
}

// Springs with a cut reach the state of one process.
TEST(OneBody, Springs_EqualsOneProcess) { expect_the_same(scene_text(kSprings, kAlong), {2, 3}); }

// PBD with a cut reaches the state of one process.
TEST(OneBody, Pbd_EqualsOneProcess) { expect_the_same(scene_text(kProjections, kAlong), {4}); }

// A CT in a file is read in slices per process, and the body reaches the state of one process.
TEST(OneBody, Files_ReadBySlices) {
  PhantomParams phantom{.size = {56, 44, 60}, .spacing = {8e-3, 8e-3, 5e-3}};
  CtVolume ct = make_phantom(Exec(2), phantom);
  ct.grid.axes.column[0] = -ct.grid.axes.column[0];  // left-handed: read mirrored
  for (const std::string name : {"ct.nii", "ct.mhd"}) {
    const Folder folder(
        "[world]\nduration = 0.06\nframe_rate = 50\n[body.torso]\nmodel = \"lattice\"\nct = \"" + name +
        "\"\nblock = 2\nfixed = [\"bone\", \"ends\"]\n" + kSprings + "\n");
    write_raw(folder.path / name, ct);
    const Alone alone = run_alone(folder);
    const Ended ended = run_shared(folder, 3);
    ASSERT_EQ(ended.code, 0) << ended.printed;
    const nlohmann::json report = report_of(folder);
    EXPECT_EQ(report["state_hash"], hash_text(alone.hash)) << name;
    for (const auto& process : report["processes"])  // 8 to 12 layers of 31; blocks of neighbors overlap
      EXPECT_LE(process["voxels_read"].get<std::size_t>(), ct.samples.size() * 13 / 31);
  }
}

// The run writes the displacements of all nodes.
TEST(OneBody, WritesNodeDisplacements) {
  const Folder folder(scene_text(kSprings, kAlong));
  const Alone alone = run_alone(folder);
  ASSERT_EQ(run_shared(folder, 3).code, 0);
  const VectorVolume found = read_vectors(folder.path / "out" / "displacement.mhd").value();
  const lattice::Model& model = alone.world.lattice_bodies[0].model;
  const lattice::State& state = alone.world.lattice_bodies[0].state;
  ASSERT_TRUE(same_grid(found.grid, model.anatomy.grid));
  double largest = 0;
  for (int k = 0; k < model.anatomy.grid.size.z; k++)
    for (int j = 0; j < model.anatomy.grid.size.y; j++)
      for (int i = 0; i < model.anatomy.grid.size.x; i++) {
        const int slot = node_slot(model.anatomy.lattice, i, j, k);
        const Vec3 expected =
            lattice::is_solid(model, state.cuts, slot) ? state.motion.u[std::size_t(slot)] * 1e3f : Vec3{};
        ASSERT_LT(norm(found.at(i, j, k) - expected), 1e-6f) << i << " " << j << " " << k;
        largest = std::max(largest, double(norm(expected)));
      }
  EXPECT_GT(largest, 0.5);  // the body moves [mm]
  EXPECT_NEAR(report_of(folder)["largest_displacement_mm"].get<double>(), largest, 1e-3);
}

// The memory of a process shrinks with the number of processes.
TEST(OneBody, MemoryShrinksWithProcesses) {
  const Folder folder(scene_text(kSprings));
  const auto most_memory = [&](int processes) {
    EXPECT_EQ(run_shared(folder, processes).code, 0);
    const nlohmann::json report = report_of(folder);
    std::int64_t most = 0;
    for (const auto& process : report["processes"])
      most = std::max(most, process["memory_bytes"].get<std::int64_t>());
    return double(most);
  };
  const double alone = most_memory(1), three = most_memory(3);
  EXPECT_LT(three, alone * (12 + 5 + 2) / 27);  // owned and ghost layers, and the border of all
}

// A body with too few layers of nodes for its processes is refused.
TEST(OneBody, RejectsTooFewLayers) {
  const Folder folder(scene_text(kSprings));
  const Ended ended = run_shared(folder, 3, "--set body.torso.block=24");
  EXPECT_EQ(ended.code, 2);
  EXPECT_EQ(
      ended.printed,
      "turgor_mpi: scene.toml:4:1: body.torso: a body of 3 layers of nodes is shared by at most 1 processes, "
      "4 layers each: found 3 processes\n");
}

// A failure of one process ends all of them with one message.
TEST(OneBody, OneFailureEndsAllProcesses) {
  const Folder folder("[body.torso]\nmodel = \"lattice\"\nct = \"ct.mhd\"\nblock = 2\n" + kSprings + "\n");
  const CtVolume ct = make_phantom(Exec(2), {.size = {32, 24, 48}, .spacing = {12e-3, 12e-3, 6e-3}});
  write_raw(folder.path / "ct.mhd", ct);
  fs::remove(folder.path / "ct.raw");
  Ended ended = run_shared(folder, 3);
  EXPECT_EQ(ended.code, 2);
  EXPECT_NE(ended.printed.find("turgor_mpi: "), std::string::npos) << ended.printed;
  EXPECT_EQ(ended.printed.find("turgor_mpi: "), ended.printed.rfind("turgor_mpi: ")) << ended.printed;
  EXPECT_NE(ended.printed.find("ct.raw"), std::string::npos) << ended.printed;
  EXPECT_FALSE(fs::exists(folder.path / "out"));
}

// Features that processes cannot share are refused with a message that names the key.
TEST(OneBody, RejectsUnsupportedKeys) {
  const struct {
    std::string body, rest, key;
  } cases[] = {
      {"", "", "body.torso.solver.coarse"},
      {"solver = { coarse = false, ordering = \"colors\" }", "", "body.torso.solver.ordering"},
      {"solver = { coarse = false, sleep_speed = 0.001 }", "", "body.torso.solver.sleep_speed"},
      {kSolid + "\nonly = 5", "", "body.torso.only"},
      {kSolid, "[incision.a]\nbody = \"torso\"\nfrom_fraction = [0.5, 0, 0.6]\nto_fraction = [0.5, 0, 0.4]\n",
       "incision.a.from_fraction"},
      {kSolid, "[output]\ndeformed_ct = \"deformed.nii.gz\"\n", "output.deformed_ct"},
      {kSolid,
       "[tool.finger]\nbody = \"torso\"\nshape = { sphere = 0.01 }\npress = { at_fraction = [0.5, 0, 0.5], "
       "depth = 0.006 }\n",
       "tool"},
      {kSolid,
       "[body.stone]\nmodel = \"rigid\"\nshape = { sphere = 0.01 }\nat = [0, -0.3, 0]\n"
       "density = 1000\n",
       "body"},
      {kSolid,
       "[attachment.table]\nbetween = [\"torso\", \"ground\"]\nbox = [[-1, -1, -1], [1, 1, 1]]\n"
       "stiffness = 1e3\n",
       "attachment"},
  };
  for (const auto& [body, rest, key] : cases) {
    const Status known = mpi::check_scene(parse_scene(scene_text(body, rest), "scene.toml").value());
    ASSERT_FALSE(known) << key;
    EXPECT_NE(known.error().message.find(key + ": several processes "), std::string::npos)
        << known.error().message;
  }
  EXPECT_TRUE(mpi::check_scene(parse_scene(scene_text(kSolid, kAlong + kAcross), "scene.toml").value()));
}

// A refused scene is reported once for all processes.
TEST(OneBody, PrintsErrorOnce) {
  const Folder folder(scene_text(""));
  const Ended ended = run_shared(folder, 2);
  EXPECT_EQ(ended.code, 2);
  EXPECT_EQ(
      ended.printed,
      "turgor_mpi: scene.toml:4:1: body.torso.solver.coarse: several processes do not support the coarse "
      "space, the default of solid tissue: expected coarse = false\n");
}

}  // namespace turgor

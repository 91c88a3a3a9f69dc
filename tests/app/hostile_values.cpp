// Absurd values of flags and scene keys. The program always answers with a result or a message, never with a
// signal or a hang. Runs tiny scenes with limits on time and memory.
#include "tests/app/program.hpp"

namespace turgor {
namespace {

using namespace test;

const std::vector<std::string> kHostile = {"nan",
                                           "inf",
                                           "-inf",
                                           "-1",
                                           "0",
                                           "1e308",
                                           "-1e308",
                                           "1e-308",
                                           "2147483648",
                                           "-2147483649",
                                           "9223372036854775808",
                                           "\"\"",
                                           "[]",
                                           "{}",
                                           "\xff\xfe",
                                           "true"};

std::string quoted(const std::string& text) { return "'" + text + "'"; }

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
const std::string kMemory;  // sanitizers reserve terabytes
#else
const std::string kMemory = "ulimit -v 8000000 && ";  // [kB]
#endif

/// Runs with limits on seconds and kilobytes that no tiny scene needs.
Ended run_bounded(const std::string& arguments, const fs::path& folder) {
  return run_shell(kMemory + "timeout -s KILL 60 '" TURGOR_PROGRAM "' " + arguments + " </dev/null", folder);
}

void expect_answer(const std::string& arguments, const fs::path& folder) {
  const Ended ended = run_bounded(arguments, folder);
  EXPECT_TRUE(ended.code == 0 || ended.code == 2 || ended.code == 3)
      << "turgor " << arguments << "\nexit code " << ended.code << "\n"
      << ended.printed;
  if (ended.code == 2) {
    EXPECT_NE(ended.printed.find("turgor: "), std::string::npos) << arguments << "\n" << ended.printed;
  }
}

const char* const kPad = R"([world]
duration = 0.03
frame_rate = 50
[body.pad]
model = "sfem"
block = { size = [0.04, 0.04, 0.02], count = [4, 4, 2] }
fixed = { sides = "bottom", depth = 0.1 }
patch = { radius = 0.01, refinement = 2, hysteresis = 0.25 }
viscosity = { ratio = 0.5, time = 0.3 }
inclusion = { hard = { center_fraction = [0.5, 0.5, 0.5], radius = 0.01, young = 4e4 } }
cache = false
[tool.finger]
body = "pad"
shape = { sphere = 0.006 }
press = { at_fraction = [0.5, 0.5, 1], depth = 0.002, start = 0, duration = 0.01, hold = 0.005 }
[output]
snapshots = { every = 0.5, size = [64, 64] }
video = false
recording = false
)";
const char* const kLiver = R"([world]
duration = 0.03
frame_rate = 50
[body.liver]
model = "rhombus"
surface = { phantom = "liver", detail = 0.3 }
[tool.forceps]
body = "liver"
shape = { forceps = "phantom", opening = 0.012, closing = 0.01 }
grasp = { at_fraction = [0.3, 0.5, 1], depth = 0.006, pull = 0.015, start = 0, duration = 0.01, hold = 0.01 }
[output]
snapshots = { every = 0.5, size = [64, 64] }
video = false
recording = false
)";

struct Swept {
  const char* name;
  std::string text;
  std::vector<std::string> keys;
};

const std::vector<Swept>& swept() {
  static const std::vector<Swept> all = {
      {"pad.toml",
       kPad,
       {"world.gravity",
        "world.duration",
        "world.frame_rate",
        "body.pad.block.size",
        "body.pad.block.count",
        "body.pad.young",
        "body.pad.poisson",
        "body.pad.fixed",
        "body.pad.fixed.depth",
        "body.pad.elements",
        "body.pad.formulation",
        "body.pad.patch",
        "body.pad.patch.radius",
        "body.pad.patch.refinement",
        "body.pad.patch.hysteresis",
        "body.pad.viscosity.ratio",
        "body.pad.viscosity.time",
        "body.pad.inclusion.hard.radius",
        "body.pad.inclusion.hard.young",
        "body.pad.inclusion.hard.poisson",
        "body.pad.inclusion.hard.center_fraction",
        "body.pad.rotations",
        "body.pad.precision",
        "body.pad.memory",
        "body.pad.contacts",
        "body.pad.cache",
        "body.pad.seen",
        "body.pad.seen_scale",
        "body.pad.mesh",
        "tool.finger.body",
        "tool.finger.shape",
        "tool.finger.shape.sphere",
        "tool.finger.shape.capsule",
        "tool.finger.friction",
        "tool.finger.press.at_fraction",
        "tool.finger.press.depth",
        "tool.finger.press.start",
        "tool.finger.press.duration",
        "tool.finger.press.hold",
        "tool.finger.press.slide",
        "tool.finger.path",
        "output.snapshots.every",
        "output.snapshots.size",
        "output.color",
        "output.color_range",
        "output.obj",
        "output.mesh_unit",
        "output.mesh_frame"}},
      {"liver.toml", kLiver, {"body.liver.surface.detail",  "body.liver.tissue",
                              "body.liver.chain.normal",    "body.liver.chain.tangential",
                              "body.liver.chain.decay",     "body.liver.chain.angle",
                              "body.liver.chain.side",      "body.liver.chain.boundary",
                              "body.liver.bulge",           "body.liver.tear",
                              "body.liver.viscosity.ratio", "body.liver.viscosity.time",
                              "tool.forceps.shape.scale",   "tool.forceps.shape.opening",
                              "tool.forceps.shape.closing", "tool.forceps.grasp.depth",
                              "tool.forceps.grasp.pull",    "tool.forceps.grasp.aside",
                              "tool.forceps.grasp.start",   "tool.forceps.grasp.duration",
                              "tool.forceps.grasp.hold"}}};
  return all;
}

/// A share of the keys, so that no test takes minutes.
class HostileKeys : public testing::TestWithParam<int> {};
constexpr int kShares = 8;

// Every key of a scene with a tool gets a result or a message for every absurd value.
TEST_P(HostileKeys, AbsurdValuesGetAnswer) {
  const fs::path folder = fresh_folder();
  for (const Swept& scene : swept()) {
    write(folder / scene.name, scene.text);
    const Ended plain = run_bounded(std::string("run ") + scene.name + " -q --out o", folder);
    ASSERT_EQ(plain.code, 0) << plain.printed;
    for (std::size_t k = std::size_t(GetParam()); k < scene.keys.size(); k += kShares)
      for (const std::string& value : kHostile)
        expect_answer(
            std::string("run ") + scene.name + " -q --out o --set " + quoted(scene.keys[k] + "=" + value),
            folder);
  }
}
INSTANTIATE_TEST_SUITE_P(Shares, HostileKeys, testing::Range(0, kShares));

// Combinations of extreme but valid values get a result or a message.
TEST(HostileValues, CombinedExtremesGetAnswer) {
  const fs::path folder = fresh_folder();
  write(folder / "pad.toml", kPad);
  const std::vector<std::string> sets = {
      "--set body.pad.formulation=averaged --set body.pad.poisson=0.49995",
      "--set body.pad.formulation=averaged --set body.pad.poisson=0.4999999999",
      "--set body.pad.poisson=0.49999999999999 --set body.pad.patch.refinement=4",
      "--set body.pad.poisson=-0.99999999999",
      "--set body.pad.young=1e-300",
      "--set body.pad.young=1e300",
      "--set body.pad.young=1e300 --set body.pad.inclusion.hard.young=1e-300",
      "--set 'body.pad.block.size=[1e-9,1e-9,1e-9]'",
      "--set 'body.pad.block.size=[99,1e-6,99]'",
      "--set 'body.pad.block.count=[1,1,1]'",
      "--set body.pad.patch.refinement=4 --set body.pad.patch.radius=0.9",
      "--set tool.finger.press.depth=0.99",
      "--set tool.finger.press.duration=1e-9",
      "--set body.pad.viscosity.time=1e-12 --set body.pad.viscosity.ratio=100",
      "--set world.frame_rate=1 --set world.duration=1",
      "--set body.pad.rotations=true --set tool.finger.press.depth=0.02"};
  for (const std::string& set : sets) expect_answer("run pad.toml -q --out o " + set, folder);
}

// Every flag gets a result or a message for every absurd value.
TEST(HostileValues, AbsurdFlagsGetAnswer) {
  const fs::path folder = fresh_folder();
  write(folder / "pad.toml", kPad);
  write(folder / "box.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nf 4 3 2 1\nf 5 6 7 8\nf 1 2 "
        "6 5\n"
        "f 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
  write(folder / "curve.csv", "depth,force\n0,0\n0.001,0.01\n0.002,0.03\n0.003,0.06\n0.004,0.1\n");
  const std::vector<std::string> flags = {
      "info box.obj --scale ",
      "info box.obj --series ",
      "info ",
      "import box.obj -o ",
      "import -o x.nii ",
      "mesh box.obj -o m.msh --scale ",
      "mesh box.obj -o m.msh --size ",
      "mesh box.obj --label 1 -o ",
      "mesh box.obj -o m.msh --label ",
      "phantom torso -o p.nii --spacing 5 5 ",
      "phantom torso -o p.nii --size 9 9 ",
      "phantom liver -o l.obj --detail ",
      "phantom torso --size 16 16 16 -o p.nii --seed ",
      "phantom ",
      "calibrate curve.csv -o c --side ",
      "calibrate ",
      "bench rhombus --threads ",
      "bench cloth --largest ",
      "bench sfem --largest ",
      "bench skin-tension --shrink ",
      "bench skin-tension --only ",
      "bench ",
      "validate ",
      "cache --folder ",
      "run pad.toml -q --out o --threads ",
      "run pad.toml -q --out o --set ",
      "run pad.toml -q --out o --require ",
      "run pad.toml -q --out o --real-time --rate ",
      "run pad.toml -q --out o --real-time --device ",
      "run pad.toml -q --out o --real-time --tool ",
      "run pad.toml -q --out o --real-time --device replay --device-file ",
      "run --replay ",
      "run ",
      "--threads "};
  for (const std::string& flag : flags)
    for (const std::string& value : kHostile) {
      const bool slow = flag.starts_with("bench rhombus") && (value == "0" || value == "true");
      if (!slow) expect_answer(flag + quoted(value), folder);
    }
}

}  // namespace
}  // namespace turgor

// The tables of pairs in docs/organs-in-contact.md: every cell is loaded and run, or refused.
#include <fstream>
#include <sstream>

#include <fmt/format.h>

#include "organs_scene.hpp"
#include "turgor/geometry/ball_mesh.hpp"
#include "turgor/io/mesh/mesh_files.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kPairKinds = {"sfem", "rigid", "lattice", "chains", "cloth", "ground"};

/// A block of voxels of 4 mm in air, 32 mm wide and 20 mm high, on bone or not. Its bottom is at z.
CtVolume small_block_ct(double bottom, bool on_bone) {
  CtVolume ct;
  ct.grid.size = {16, 16, 13};
  ct.grid.spacing = {0.004, 0.004, 0.004};
  ct.grid.origin = {-0.03, -0.03, bottom - 0.014};
  ct.samples.assign(sample_count(ct.grid), kAirHu);
  for (int k = 4; k < 9; k++)
    for (int j = 4; j < 12; j++)
      for (int i = 4; i < 12; i++) ct.at(i, j, k) = on_bone && k < 6 ? 1000 : -100;
  return ct;
}

/// [body.NAME] of a kind: a lower body below z = 0 that something holds, or an upper body above 0.5 mm that
/// nothing holds.
std::string pair_body(const std::string& kind, bool is_upper, const fs::path& folder) {
  const std::string name = is_upper ? "upper" : "lower";
  const double bottom = is_upper ? 0.0005 : -0.02;
  if (kind == "sfem")
    return test::block_text(name, fmt::format("[-0.015, -0.015, {}]", bottom), "[0.03, 0.03, 0.02]",
                            "[3, 3, 2]", is_upper ? "none" : "bottom") +
           (is_upper ? "density = 1000\n" : "");
  if (kind == "rigid") {
    const double side = is_upper ? 0.022 : 0.03;
    const std::string body = fmt::format(
        "[body.{}]\nmodel = \"rigid\"\nshape = {{ box = [{}, {}, 0.02] }}\nat = [0, 0, {}]\nmass = 0.02\n",
        name, side, side, bottom + 0.01);
    if (is_upper) return body;
    return body +
           "[attachment.hold]\nbetween = [\"lower\", \"ground\"]\nat = [[0.015, 0, -0.02], [-0.015, 0, "
           "-0.02], "
           "[0, 0.015, -0.02]]\nstiffness = 1e5\n";
  }
  if (kind == "lattice") {
    EXPECT_TRUE(write_ct(folder / (name + ".nii"), small_block_ct(bottom, !is_upper)));
    return fmt::format(
        "[body.{}]\nmodel = \"lattice\"\nct = \"{}.nii\"\nblock = 1\nfixed = \"{}\"\nskin.tension = 0\n",
        name, name, is_upper ? "none" : "bone");
  }
  if (kind == "chains") {
    TriMesh ball = ball_mesh(Real(0.02), 3);
    for (Vec3& x : ball.vertices) x.z += Real(bottom + 0.02 - (is_upper ? 0 : 0.02));
    EXPECT_TRUE(write_obj(folder / (name + ".obj"), ball));
    return fmt::format("[body.{}]\nmodel = \"rhombus\"\nsurface = \"{}.obj\"\n", name, name);
  }
  if (kind == "cloth")
    return fmt::format(
        "[body.{}]\nmodel = \"cloth\"\nsheet = {{ corner = [-0.01, -0.01, {}], side = [0.02, 0, 0], up = [0, "
        "0.02, 0], "
        "columns = 5, rows = 5 }}\ncollision = {{ thickness = 0.0005 }}\n",
        name, is_upper ? 0.0005 : -0.0005);
  return "";
}

/// Scene with an upper body of one kind and a lower one of another, and its results in the words of the
/// tables.
struct PairScene {
  std::string upper, lower;
  fs::path folder = test::fresh_folder();

  std::string lower_name() const { return lower == "ground" ? "ground" : "lower"; }
  Result<Scene> parsed(const std::string& coupling) const {
    return parse_scene("[world]\nduration = 9\ngravity = [0, 0, -9.81]\n" + pair_body(upper, true, folder) +
                           pair_body(lower, false, folder) + coupling,
                       folder / "pair.toml");
  }
  /// Runs some frames. Falling upper bodies must have met a force, others must be near.
  void run(const Exec& exec, const Scene& scene) const {
    const std::string pair = upper + " on " + lower;
    Result<World> world = load_world(exec, scene);
    ASSERT_TRUE(world) << pair << ": " << world.error().message;
    double force = 0;
    std::size_t points = 0;
    for (int frame = 0; frame < 8; frame++) {
      test::advance(exec, *world, 1);
      for (const BodyContact& contact : world->coupling.contacts) points += contact.sites.size();
    }
    for (const BodyContact& contact : world->coupling.contacts)
      for (const CouplingSample& sample : contact.samples) force += norm(sample.force);
    for (const Attachment& attachment : world->coupling.attachments)
      if (attachment.name == "pair") {
        points += attachment.ties.size();
        for (const CouplingSample& sample : attachment.samples) force += norm(sample.force);
      }
    for (const ClothBody& cloth : world->cloth_bodies) {
      if (cloth.obstacles.empty()) continue;
      points += cloth.obstacles.size();
      EXPECT_TRUE(upper == "cloth") << pair;
      force += 1;
    }
    EXPECT_GT(points, 0u) << pair;
    const bool falls_together = upper == "cloth" && lower == "cloth";  // nothing holds either
    EXPECT_TRUE(upper == "chains" || falls_together || force > 1e-4) << pair << ": " << force << " N";
    EXPECT_TRUE(std::isfinite(force)) << pair;
  }
  /// The pair by `[contact]`, by an obstacle of cloth, or refused.
  std::string contact(const Exec& exec) const {
    const std::string text = fmt::format("[contact.pair]\nbetween = [\"upper\", \"{}\"]\n", lower_name());
    const Result<Scene> touching = parsed(text);
    if (touching) return run(exec, *touching), "yes";
    if (touching.error().message.find("obstacle") == std::string::npos) return touching.error().message;
    const Result<Scene> scene =
        parsed("[body.upper.obstacle.pair]\n" +
               std::string(lower == "ground" ? "plane = { through = [0, 0, 0], normal = [0, 0, 1] }\n"
                                             : "body = \"lower\"\n"));
    return scene ? (run(exec, *scene), "obstacle") : "refused";
  }
  std::string attachment(const Exec& exec) const {
    const std::string text =
        fmt::format("[attachment.pair]\nbetween = [\"upper\", \"{}\"]\ndistance = 0.002\nstiffness = 40\n{}",
                    lower_name(), lower == "ground" ? "box = [[-1, -1, -0.1], [1, 1, 0.004]]\n" : "");
    const Result<Scene> scene = parsed(text);
    return scene ? (run(exec, *scene), "yes") : scene.error().message;
  }
};

/// Cells of a table of the page, by row and column.
std::string cell_of_page(const std::string& table, const std::string& row, std::size_t column) {
  std::ifstream file(fs::path(TURGOR_SOURCE_DIR) / "docs" / "organs-in-contact.md");
  bool is_inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("| " + table + " |")) is_inside = true;
    if (!line.starts_with("|")) is_inside = false;
    if (!is_inside || !line.starts_with("| " + row + " |")) continue;
    std::istringstream cells(line.substr(1));
    std::string cell;
    for (std::size_t n = 0; n < column + 2; n++) std::getline(cells, cell, '|');
    return cell.substr(1, cell.size() - 2);
  }
  return "no such row";
}

// Every pair of the page's tables touches as its cell says.
TEST(PairTable, Contacts_AreAsOnPage) {
  const Exec exec(2);
  for (std::size_t row = 0; row + 1 < kPairKinds.size(); row++)
    for (std::size_t column = 0; column < kPairKinds.size(); column++) {
      const std::string cell = cell_of_page("contact", kPairKinds[row], column);
      const bool is_cloth_below = kPairKinds[column] == "cloth" && kPairKinds[row] != "cloth";
      const PairScene pair{kPairKinds[is_cloth_below ? column : row],
                           kPairKinds[is_cloth_below ? row : column]};
      EXPECT_EQ(pair.contact(exec), cell) << kPairKinds[row] << " and " << kPairKinds[column];
    }
}

// Every pair of the page's tables is attached as its cell says.
TEST(PairTable, Attachments_AreAsOnPage) {
  const Exec exec(2);
  for (std::size_t row = 0; row + 1 < kPairKinds.size(); row++)
    for (std::size_t column = 0; column < kPairKinds.size(); column++)
      EXPECT_EQ((PairScene{kPairKinds[row], kPairKinds[column]}.attachment(exec)),
                cell_of_page("attachment", kPairKinds[row], column))
          << kPairKinds[row] << " and " << kPairKinds[column];
}

}  // namespace
}  // namespace turgor

#include "app/validate_sfem.hpp"

#include <cmath>

#include <fmt/format.h>

#include "app/pressed_block.hpp"
#include "turgor/core/timing.hpp"
#include "turgor/geometry/hex_block.hpp"

namespace turgor {

namespace {

using sfem::Body;
using sfem::Model;

/// Planes of a block, dense in the middle and wider towards the sides.
std::vector<double> graded(double half_width, double finest, double growth) {
  std::vector<double> half{0};
  for (double step = finest; half.back() < half_width; step *= growth) half.push_back(half.back() + step);
  for (double& x : half) x *= half_width / half.back();
  std::vector<double> planes;
  for (std::size_t i = half.size(); i-- > 1;) planes.push_back(-half[i]);
  planes.insert(planes.end(), half.begin(), half.end());
  return planes;
}

Result<double> plate_force(const Exec& exec, Int3 count, int refinement, int* local_nodes) {
  const Vec3d size{0.1, 0.1, 0.01};
  const auto is_side = [](Vec3d x) {
    return x.x < 1e-9 || x.y < 1e-9 || x.x > 0.1 - 1e-9 || x.y > 0.1 - 1e-9;
  };
  const sfem::Params params{.precision = sfem::Precision::kDouble, .touch_depth = 0.01};
  Result<Model> model = solved(exec, held(hex_block(size, count), {1e5, 0.4}, is_side), params);
  if (!model) return model.error();
  const Vec3d tip{0.05, 0.05, 0.01};
  // The four elements around the center, or as many of a finer plate as lie within.
  const sfem::Patch patch = patch_at(exec, *model, tip, {0.02, refinement});
  *local_nodes = patch.local_nodes;
  for (std::size_t p = 0; p < patch.points.size(); p++) {
    if (norm(patch.points[p].x - tip) > 1e-9) continue;
    Mat3d block;  // displacement of the point under unit forces on it
    for (std::size_t i = 0; i < 9; i++)
      block.column[i / 3][int(i % 3)] =
          patch.compliance[(3 * p + i / 3) * 3 * patch.points.size() + 3 * p + i % 3];
    return (inverse(block) * Vec3d{0, 0, -0.003}).z;
  }
  return Error{"the plate has no node at its center"};
}

}  // namespace

Result<std::vector<PlateRow>> validate_plate(const Exec& exec) {
  struct Expected {
    const char* mesh;
    Int3 count;
    int refinement;
    double force;
  };
  static constexpr Expected kRows[] = {{"4 x 4 x 1, the paper's 16 elements", {4, 4, 1}, 1, -1.04722},
                                       {"4 x 4 x 1, patch of 2 x 2, r = 2", {4, 4, 1}, 2, -0.729968},
                                       {"4 x 4 x 1, patch of 2 x 2, r = 3", {4, 4, 1}, 3, -0.599702},
                                       {"4 x 4 x 1, patch of 2 x 2, r = 4", {4, 4, 1}, 4, -0.522144},
                                       {"8 x 8 x 1", {8, 8, 1}, 1, -0.672865},
                                       {"8 x 8 x 2", {8, 8, 2}, 1, -0.584958},
                                       {"12 x 12 x 1, the paper's 144 elements", {12, 12, 1}, 1, -0.574669},
                                       {"12 x 12 x 3", {12, 12, 3}, 1, -0.456165},
                                       {"16 x 16 x 4", {16, 16, 4}, 1, -0.393929}};
  std::vector<PlateRow> rows;
  for (const Expected& expected : kRows) {
    PlateRow row{expected.mesh, 0, expected.force, 0};
    const Result<double> found = plate_force(exec, expected.count, expected.refinement, &row.local_nodes);
    if (!found) return found.error();
    row.found = *found;
    rows.push_back(row);
  }
  return rows;
}

Result<HertzResult> validate_hertz(const Exec& exec) {
  // Hertz's formula is the limit of small contacts. The contact radius √(R d) is 3 % of the sphere's, and the
  // block extends a hundred contact radii to each side and down.
  HertzResult result;
  result.radius = 0.1, result.young = 5e3, result.poisson = 0.3;
  constexpr double kDepth = 8e-5, kHalfWidth = 0.3, kFinest = 0.0025, kGrowth = 1.28;
  const std::vector<double> x = graded(kHalfWidth, kFinest, kGrowth);
  std::vector<double> z = x;
  z.resize(z.size() / 2 + 1);  // from the deepest plane to the surface
  const auto is_bottom = [](Vec3d p) { return p.z < -kHalfWidth + 1e-9; };
  sfem::Params params;
  params.touch_depth = 0.02, params.precision = sfem::Precision::kDouble;
  Result<Model> model =
      solved(exec, held(hex_block(x, x, z), {result.young, result.poisson}, is_bottom), params, true);
  if (!model) return model.error();
  result.nodes = int(model->vertex.size());
  const sfem::Patch fine = patch_at(exec, *model, {}, {0.0105, 3});
  const sfem::Patch coarse = patch_at(exec, *model, {}, {0.0105, 1});
  result.local_nodes = fine.local_nodes;
  constexpr int kSteps = 8;
  const auto with = press(fine, {}, result.radius, kDepth, kSteps);
  const auto without = press(coarse, {}, result.radius, kDepth, kSteps);
  const double modulus = result.young / (1 - result.poisson * result.poisson);
  for (std::size_t i = 1; i < with.size(); i++) {
    const double d = with[i].first;
    result.rows.push_back({d, 4.0 / 3 * modulus * std::sqrt(result.radius) * std::pow(d, 1.5), with[i].second,
                           without[i].second});
  }
  return result;
}

Result<std::vector<RefinementRow>> validate_refinement(const Exec& exec, bool fine,
                                                       const Progress& progress) {
  struct MeshChoice {
    int divisions;  // of the block's 80 mm
    int refinement;
  };
  std::vector<MeshChoice> choices{{8, 1}, {8, 2}, {8, 3}, {8, 4}, {16, 1}, {16, 2}, {24, 1}};
  if (fine) choices.push_back({32, 1});
  constexpr double kSize = 0.08, kRadius = 0.01, kDepth = 0.003;
  std::vector<RefinementRow> rows;
  for (const auto [divisions, refinement] : choices) {
    const auto is_bottom = [](Vec3d x) { return x.z < 1e-9; };
    const SolidMesh mesh = hex_block({kSize, kSize, kSize / 2}, {divisions, divisions, divisions / 2});
    sfem::Params params;
    params.touch_depth = 0.02;
    RefinementRow row;
    row.global = refinement == 1;
    row.mesh = fmt::format("{0} x {0} x {1}", divisions, divisions / 2);
    if (!row.global) row.mesh += fmt::format(", patch r = {}", refinement);
    const Timer precompute;
    const bool on_demand = divisions > 16;  // the reference is touched at one point only
    Result<Model> model = solved(exec, held(mesh, {3e3, 0.45}, is_bottom), params, on_demand);
    if (!model) return model.error();
    row.precompute = precompute.seconds();
    const Vec3d point{kSize / 2, kSize / 2, kSize / 2};
    const Timer rebuild;
    const sfem::Patch patch = patch_at(exec, *model, point, {0.018, refinement});
    row.rebuild = rebuild.seconds();
    row.nodes = int(model->vertex.size()), row.local_nodes = patch.local_nodes;
    row.force_of_depth = press(patch, point, kRadius, kDepth, 12);
    rows.push_back(row);
    if (progress) progress(double(rows.size()) / double(choices.size()));
  }
  return rows;
}

Result<NoduleResult> validate_nodule(const Exec& exec, int columns, double width, const Progress& progress) {
  NoduleResult result;
  result.columns = result.rows = columns;
  result.low = 0.25 * width, result.high = 0.75 * width;
  result.center_x = width / 2 + 0.006, result.center_y = width / 2 - 0.003;
  result.radius = 0.006, result.depth = 0.010;
  struct MeshChoice {
    const char* mesh;
    int divisions, refinement;  // of a cell
  };
  constexpr double kCell = 0.005;
  const double height = width / 2;
  const int cells = int(std::lround(width / kCell));
  const MeshChoice choices[] = {{"coarse, 5 mm", 1, 1}, {"superposed, 2.5 mm", 1, 2}, {"fine, 2.5 mm", 2, 1}};
  int done = 0;
  for (const MeshChoice& choice : choices) {
    const SolidMesh mesh =
        hex_block({width, width, height},
                  {choice.divisions * cells, choice.divisions * cells, choice.divisions * cells / 2});
    Body body = held(mesh, {3e3, 0.45}, [](Vec3d x) { return x.z < 1e-9; });
    body.materials.push_back({6e4, 0.45});
    body.inclusions.push_back({{result.center_x, result.center_y, height - result.depth}, result.radius, 1});
    constexpr double kPatch = 0.0135;
    sfem::Params params;
    params.touch_depth = kPatch;
    Result<Model> model = solved(exec, std::move(body), params, choice.divisions > 1);
    if (!model) return model.error();
    NoduleMap map{choice.mesh, int(model->vertex.size()), {}};
    for (int j = 0; j < columns; j++)
      for (int i = 0; i < columns; i++) {
        const double step = (result.high - result.low) / (columns - 1);
        const Vec3d point{result.low + i * step, result.low + j * step, height};
        const sfem::Patch patch = patch_at(exec, *model, point, {kPatch, choice.refinement});
        map.force.push_back(press(patch, point, 0.006, 0.003, 4).back().second);
        if (progress) progress(double(++done) / (3 * columns * columns));
      }
    result.maps.push_back(std::move(map));
  }
  return result;
}

}  // namespace turgor

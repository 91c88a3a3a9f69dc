#include <cmath>
#include <tuple>

#include <gtest/gtest.h>

#include "turgor/pictures/outputs.hpp"

namespace turgor {
namespace {

WorldSnapshot with_vertices(std::vector<Vec3> x) {
  WorldSnapshot snapshot;
  BodySnapshot& body = snapshot.bodies.emplace_back();
  body.rest = {{0, 0, 0}, {0.1f, 0, 0}, {0, 0, 0.1f}};
  body.triangles = {{0, 1, 2}};
  body.x = std::move(x);
  return snapshot;
}

// The camera for a comparison shows all vertices of both moments.
TEST(Views, CameraOfTwoMomentsShowsBoth) {
  Scene scene;
  Outputs outputs;
  outputs.scene = &scene;
  outputs.views = {{.name = "body", .caption = "the body", .camera = {.eye = {0.3, -1, 0.2}, .target = {}}}};
  const WorldSnapshot first = with_vertices({{0, 0, 0}, {0.1f, 0, 0}, {0, 0, 0.1f}}),
                      last = with_vertices({{0.4f, -0.3f, 0.2f}, {0.5f, -0.2f, 0}, {0.2f, -0.1f, 0.6f}});
  for (const bool colored : {false, true}) {
    outputs.views[0].colored = colored;
    const Camera camera = camera_of_both(outputs, first, last);
    const CameraFrame frame = camera_frame(camera);
    double farthest = 0;  // largest distance from the center of the picture, whose upper edge is at 1
    for (const WorldSnapshot* snapshot : {&first, &last})
      for (const Vec3 x : snapshot->bodies[0].x) {
        const Vec3d seen = Vec3d(x) - camera.eye;
        const double half = -dot(seen, frame.back) * frame.tan_half;
        ASSERT_GT(half, 0);
        EXPECT_LT(std::abs(dot(seen, frame.up)) / half, 1);
        EXPECT_LT(std::abs(dot(seen, frame.right)) / half, 4.0 / 3);
        farthest = std::max(farthest, std::abs(dot(seen, frame.up)) / half);
      }
    EXPECT_GT(farthest, 0.5) << "the bodies fill the picture";
    EXPECT_LT(norm(cross(camera.eye - camera.target, outputs.views[0].camera.eye)), 1e-9)
        << "the viewing direction is kept";
  }
}

// Inclusions are visible through the body, unless the body is colored by a quantity.
TEST(Views, InnerSurfaceIsSeenThroughUnlessColored) {
  BodySnapshot body = with_vertices({{0, 0, 0}, {0.1f, 0, 0}, {0, 0, 0.1f}}).bodies[0];
  body.normals.assign(3, {0, -1, 0});
  body.displacement.assign(3, {});
  body.wall_begin = 1;
  body.name = "liver", body.inside_names = {"nodule", "cyst"};
  body.inside = {.vertices = body.x, .triangles = body.triangles, .normals = body.normals, .scalars = {}};
  PictureItems plain, colored;
  add_body(body, SkinColor::kNone, nullptr, plain);
  const ColorScale scale{.low = 0, .high = 0.01f, .label = "displacement [mm]", .factor = 1000};
  add_body(body, SkinColor::kDisplacement, &scale, colored);
  ASSERT_EQ(plain.items.size(), 2u);
  EXPECT_TRUE(plain.items[1].see_through);
  EXPECT_FALSE(plain.items[0].opaque || plain.items[1].is_mark);
  const std::vector<NameRow> names = shown_names(plain);
  ASSERT_EQ(names.size(), 2u);
  EXPECT_EQ(names[0].names, "liver");
  EXPECT_EQ(names[1].names, "nodule, cyst");
  EXPECT_TRUE(shown_names(colored).empty()) << "a color map has its own legend";
  ASSERT_EQ(colored.items.size(), 1u);
  EXPECT_EQ(colored.items[0].scale, &scale);
}

// Walls with colors of layers are drawn finer, with a color a vertex; a layer without one has that of walls.
TEST(Views, WallsShowColorsOfLayers) {
  BodySnapshot body = with_vertices({{0, 0, 0}, {0.1f, 0, 0}, {0, 0, 0.1f}}).bodies[0];
  body.normals.assign(3, {0, -1, 0});
  body.displacement.assign(3, {});
  body.wall_begin = 0;
  WallLayers& walls = body.wall_layers;
  walls.looks = {{"fat", Rgb{240, 214, 120}}, {"muscle", {}}};
  walls.corner.assign(4, {0, 1, 2});
  walls.weight = {{1, 0, 0}, {0.5f, 0.5f, 0}, {0, 1, 0}, {0, 0, 1}};
  walls.layer = {0, 1, WallLayers::kNoLayer, 0};
  walls.triangles = {{0, 1, 3}, {1, 2, 3}};
  PictureItems items;
  add_body(body, SkinColor::kNone, nullptr, items);
  const RenderItem& item = items.items[0];
  ASSERT_EQ(item.mesh->vertices.size(), 4u);
  EXPECT_EQ(item.mesh->vertices[1], (Vec3{0.05f, 0, 0}));
  EXPECT_EQ(item.mesh->normals[3], (Vec3{0, -1, 0}));
  ASSERT_TRUE(item.colors);
  EXPECT_EQ(*item.colors, (std::vector<Rgb>{{240, 214, 120}, kWallColor, kWallColor, {240, 214, 120}}));
  EXPECT_EQ(items.names[0].names, "fat");
  EXPECT_EQ(items.names[0].color, (Rgb{240, 214, 120}));
}

// A rigid body, a tool and an obstacle hide inclusions behind them.
TEST(Views, WhatIsNotTissueIsOpaque) {
  WorldSnapshot snapshot = with_vertices({{0, 0, 0}, {0.1f, 0, 0}, {0, 0, 0.1f}});
  BodySnapshot& body = snapshot.bodies[0];
  body.normals.assign(3, {0, -1, 0});
  body.displacement.assign(3, {});
  body.wall_begin = 1;
  body.id = {BodyKind::kRigid, 0}, body.look = Look::kCloth;
  snapshot.obstacles = {{body.x, body.triangles, {}, {}}};
  snapshot.tools.resize(1);
  snapshot.tools[0].body = body.id, snapshot.tools[0].mesh = snapshot.obstacles[0];
  PictureItems items;
  add_world(snapshot, SkinColor::kNone, nullptr, {0, -1, 0}, items, {}, 1);
  ASSERT_EQ(items.items.size(), 3u);
  for (const RenderItem& item : items.items) EXPECT_TRUE(item.opaque);
}

// An arrow of a force between organs begins at its point, is seen through the tissue and names the force;
// forces too small to see have none.
TEST(Views, ForceBetweenOrgansHasArrowAndName) {
  WorldSnapshot snapshot = with_vertices({{0, 0, 0}, {0.1f, 0, 0}, {0, 0, 0.1f}});
  snapshot.bodies[0].id = {BodyKind::kSfem, 0};
  snapshot.bodies[0].box = {{0, 0, 0}, {0.1, 0, 0.1}};
  snapshot.bodies[0].typical_force = 0.5;
  const Vec3d at{0.02, 0.01, 0.03};
  snapshot.organ_forces = {{"bed", {BodyKind::kSfem, 0}, at, {0, 0, 0.25}},
                           {"fold", {BodyKind::kSfem, 0}, at, {0, 1e-5, 0}}};
  PictureItems items;
  add_organ_forces(snapshot, items);
  ASSERT_EQ(items.items.size(), 1u);
  EXPECT_TRUE(items.items[0].see_through && items.items[0].is_mark);
  double low = 1, high = 0;
  for (const Vec3 x : items.meshes[0].vertices)
    low = std::min<double>(low, x.z), high = std::max<double>(high, x.z);
  EXPECT_NEAR(low, at.z, 1e-3);
  ASSERT_EQ(items.labels.size(), 1u);
  EXPECT_EQ(items.labels[0].text, "bed 0.25 N");
  EXPECT_NEAR(high, items.labels[0].position.z, 0.01);
  EXPECT_GT(high - low, 0.01);
}

// Organs have the colors of their names; other bodies of a model differ.
TEST(Views, OrgansDifferInColor) {
  const BodySnapshot triangle = [] {
    BodySnapshot body = with_vertices({{0, 0, 0}, {0.1f, 0, 0}, {0, 0, 0.1f}}).bodies[0];
    body.normals.assign(3, {0, -1, 0});
    body.displacement.assign(3, {});
    body.wall_begin = 1;
    return body;
  }();
  const auto names_of = [&](const std::vector<std::string>& names) {
    PictureItems items;
    for (std::size_t n = 0; n < names.size(); n++) {
      BodySnapshot body = triangle;
      body.name = names[n], body.id.index = int(n);
      add_body(body, SkinColor::kNone, nullptr, items);
    }
    return items.names;
  };
  EXPECT_EQ(names_of({"gallbladder", "liver", "stomach"}).size(), 3u);
  EXPECT_EQ(names_of({"a", "b", "c"}).size(), 3u);
  EXPECT_EQ(names_of({"stomach", "liver"})[1].color, names_of({"liver"})[0].color);
  EXPECT_EQ(names_of({"right-kidney", "left-kidney"})[0].names, "right-kidney, left-kidney");
}

/// A ball of tissue in a snapshot.
BodySnapshot tissue(BodyKind kind, Look look) {
  BodySnapshot body = with_vertices({{0, 0, 0}, {0.1f, 0, 0}, {0, 0, 0.1f}}).bodies[0];
  body.id.kind = kind, body.look = look, body.name = "liver";
  body.normals.assign(3, {0, -1, 0});
  body.displacement.assign(3, {});
  body.wall_begin = 1;
  body.box = {{0, -0.1, 0}, {0.1, 0.1, 0.2}};
  return body;
}

// Organs are wet; skin, walls of wounds and cloth are dry, and the scene's key has precedence.
TEST(Views, OrgansAreWet) {
  BodySnapshot skin = tissue(BodyKind::kLattice, Look::kSkin);
  EXPECT_TRUE(is_wet(tissue(BodyKind::kSfem, Look::kFlesh), {}));
  EXPECT_TRUE(is_wet(tissue(BodyKind::kRhombus, Look::kFlesh), {}));
  EXPECT_FALSE(is_wet(skin, {}));
  EXPECT_FALSE(is_wet(tissue(BodyKind::kCloth, Look::kCloth), {}));
  EXPECT_FALSE(is_wet(tissue(BodyKind::kSfem, Look::kFlesh), {.cutaway = {}, .wet = {{"liver", false}}}));
  skin.triangles.push_back({0, 2, 1});  // a wall
  for (const auto& [look, skin_is_wet, wall_is_wet] : {std::tuple(LookScene{}, false, false),
                                                       {LookScene{{}, {{"liver", false}}}, false, false},
                                                       {LookScene{{}, {{"liver", true}}}, true, true}}) {
    PictureItems items;
    add_body(skin, SkinColor::kNone, nullptr, items, look);
    ASSERT_EQ(items.items.size(), 2u);
    EXPECT_EQ(items.items[0].wet, wall_is_wet);
    EXPECT_EQ(items.items[1].wet, skin_is_wet);
  }
}

// The section of a CT shows its gray values in the window of the scene, without a name for one color.
TEST(Views, SectionOfCtHasGrayValues) {
  BodySnapshot body = tissue(BodyKind::kLattice, Look::kSkin);
  const LookScene look{.cutaway = CutawayScene{.body = body.id, .normal = {0, -3, 0}, .wedge = {}},
                       .wet = {},
                       .window = "bone"};
  PictureItems plain;
  add_body(body, SkinColor::kNone, nullptr, plain, look);
  EXPECT_TRUE(plain.items.back().face_pictures.empty());
  EXPECT_EQ(plain.names.size(), 2u);
  CtVolume section;
  section.grid = {.size = {2, 1, 1},
                  .spacing = {0.01, 0.02, 1},
                  .origin = {1, 2, 3},
                  .axes = {{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}}};
  section.samples = {400, 1300};
  body.sections = {section};
  PictureItems items;
  add_body(body, SkinColor::kNone, nullptr, items, look);
  EXPECT_EQ(items.names.size(), 1u);
  ASSERT_EQ(items.items.back().face_pictures.size(), 1u);
  const FacePicture& picture = items.items.back().face_pictures[0];
  EXPECT_EQ(picture.corner, (Vec3d{1, 2, 3}));
  EXPECT_EQ(picture.right, (Vec3d{0, 0.01, 0}));
  EXPECT_EQ(picture.up, (Vec3d{0, 0, 0.02}));
  EXPECT_EQ(picture.image.pixels, (std::vector<Rgb>{{128, 128, 128}, {255, 255, 255}}));
}

// A cut-away applies to its body's surface and walls, has one section of both, and leaves inclusions whole or
// cuts them.
TEST(Views, CutawayAppliesToItsBody) {
  BodySnapshot body = tissue(BodyKind::kSfem, Look::kFlesh);
  body.inside_names = {"nodule"};
  body.inside = {.vertices = body.x, .triangles = body.triangles, .normals = body.normals, .scalars = {}};
  body.triangles.push_back({0, 2, 1});
  LookScene look{CutawayScene{.body = body.id, .at = {0.5, 0.25, 1}, .normal = {0, -3, 0}, .wedge = {}}, {}};
  for (const bool cuts_inclusions : {false, true}) {
    look.cutaway->cuts_inclusions = cuts_inclusions;
    PictureItems items;
    add_body(body, SkinColor::kNone, nullptr, items, look);
    ASSERT_EQ(items.items.size(), cuts_inclusions ? 5u : 4u);
    for (const int i : {0, 1, 2}) {
      const RenderItem& item = items.items[std::size_t(i)];
      ASSERT_EQ(item.cutaway.planes, 1);
      EXPECT_LT(norm(item.cutaway.plane[0].point - Vec3d{0.05, -0.05, 0.2}), 1e-12);
      EXPECT_EQ(item.cutaway.plane[0].outward, (Vec3d{0, -1, 0}));
      EXPECT_EQ(item.is_cut_face, i == 2);
    }
    EXPECT_EQ(items.items[2].mesh->triangles.size(), 2u) << "surface and wall enclose the body together";
    EXPECT_EQ(items.items[3].cutaway.planes, cuts_inclusions ? 1 : 0);
    ASSERT_EQ(items.names.size(), 3u);
    EXPECT_EQ(items.names[1].names, "liver, cut");
  }
  look.cutaway->body.index++;
  PictureItems other;
  add_body(body, SkinColor::kNone, nullptr, other, look);
  ASSERT_EQ(other.items.size(), 3u);
  EXPECT_EQ(other.items[0].cutaway.planes, 0);
}

}  // namespace
}  // namespace turgor

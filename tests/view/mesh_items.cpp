#include "turgor/view/mesh_items.hpp"

#include <array>
#include <tuple>

#include "tests/view/drawn_in_texture.hpp"
#include "tests/view/shapes.hpp"
#include "turgor/geometry/loop_subdivision.hpp"

namespace turgor {
namespace {

constexpr Camera kFront{.eye = {0.05, -1, 0.1}, .target = {0, 0, 0}};
constexpr Rgb kRed{210, 20, 20}, kGreen{20, 190, 20};

enum class Shown : std::uint8_t { kNothing, kSurface, kFace };

Shown shown_by(Rgb c) {
  if (test::is_red(c)) return Shown::kSurface;
  return test::is_green(c) ? Shown::kFace : Shown::kNothing;
}

/// Interval of a ray's parameter.
struct Span1 {
  double begin = -1e9, end = 1e9;
};

Span1 inside_ball(Vec3d eye, Vec3d ray, double radius) {
  const double a = dot(ray, ray), b = dot(eye, ray), c = dot(eye, eye) - radius * radius;
  const double root = b * b - a * c;
  if (root < 0) return {1, 0};
  return {(-b - std::sqrt(root)) / a, (-b + std::sqrt(root)) / a};
}

/// Interval that the cut-away removes: the ray's points on the removed side of every plane.
Span1 removed(const Cutaway& cutaway, Vec3d eye, Vec3d ray) {
  Span1 span;
  for (int p = 0; p < cutaway.planes; p++) {
    const CutawayPlane& plane = cutaway.plane[p];
    const double rate = dot(ray, plane.outward), at = dot(plane.point - eye, plane.outward) / rate;
    (rate > 0 ? span.begin : span.end) = rate > 0 ? std::max(span.begin, at) : std::min(span.end, at);
  }
  return span;
}

/// The first thing along a ray that is left of a ball with a round hollow of radius `hollow` in its middle.
Shown first_along(const Cutaway& cutaway, Vec3d eye, Vec3d ray, double radius, double hollow) {
  const Span1 ball = inside_ball(eye, ray, radius), inner = inside_ball(eye, ray, hollow),
              cut = removed(cutaway, eye, ray);
  if (ball.begin > ball.end) return Shown::kNothing;
  if (ball.begin < cut.begin || ball.begin > cut.end) return Shown::kSurface;
  if (cut.end > ball.end) return Shown::kNothing;
  return cut.end > inner.begin && cut.end < inner.end ? Shown::kSurface : Shown::kFace;
}

/// Adds the surface of a hollow.
TriMesh hollow_ball(float radius, float hollow) {
  TriMesh mesh = test::sphere({}, radius, 96);
  const TriMesh inner = test::sphere({}, hollow, 96);
  const int first = int(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), inner.vertices.begin(), inner.vertices.end());
  for (const auto [a, b, c] : inner.triangles) mesh.triangles.push_back({first + a, first + c, first + b});
  return mesh;
}

CutawayPlane plane_at(Vec3d outward, double distance) {
  const Vec3d n = normalized(outward);
  return {n * distance, n};
}

class MeshItems : public test::DrawnInTexture {
 protected:
  Image draw(const std::vector<RenderItem>& items, RenderQuality quality = RenderQuality::kFull,
             const Camera& camera = kFront) {
    return DrawnInTexture::draw(items, camera, quality);
  }

  /// Compares every pixel with the first thing along its ray. Pixels at a border may show either side.
  void expect_section(const Image& image, const Cutaway& cutaway, double radius, double hollow) {
    const CameraFrame frame = camera_frame(kFront);
    const auto expected = [&](double x, double y) {
      const double u = (2 * x - kWidth) / kHeight, v = 1 - 2 * y / kHeight;
      return first_along(cutaway, kFront.eye, (frame.right * u + frame.up * v) * frame.tan_half - frame.back,
                         radius, hollow);
    };
    std::array<int, 3> counts{};
    int wrong = 0;
    for (int y = 0; y < kHeight; y++)
      for (int x = 0; x < kWidth; x++) {
        const Shown want = expected(x + 0.5, y + 0.5), found = shown_by(image.at(x, y));
        counts[std::size_t(want)]++;
        bool near = found == want;
        for (const double dx : {-0.6, 0.6})
          for (const double dy : {-0.6, 0.6}) near = near || expected(x + 0.5 + dx, y + 0.5 + dy) != want;
        wrong += !near;
      }
    EXPECT_EQ(wrong, 0);
    EXPECT_GT(counts[1], 1500) << "surface";
    EXPECT_GT(counts[2], 1500) << "cut face";
  }
};

std::vector<RenderItem> cut_ball(const TriMesh& ball, const Cutaway& cutaway) {
  return {{.mesh = &ball, .color = kRed, .closed = true, .cutaway = cutaway},
          {.mesh = &ball, .color = kGreen, .cutaway = cutaway, .is_cut_face = true}};
}

// A large closed mesh, whose back faces are not uploaded for quick pictures, looks like the same mesh in
// small pieces, from outside and close to its skin.
TEST_F(MeshItems, LargeClosedMeshMatchesItsPieces) {
  TriMesh ball = test::sphere({}, 0.15f, 96);
  for (Vec3& x : ball.vertices) x = x * (1 + 0.1f * std::sin(40 * x.x) * std::sin(50 * x.z));
  ball.normals = vertex_normals(ball);
  ASSERT_GT(ball.triangles.size(), 30000u);
  constexpr std::size_t kPieces = 4;
  std::array<TriMesh, kPieces> pieces;
  for (std::size_t p = 0; p < kPieces; p++) {
    pieces[p] = ball;
    const auto begin = ball.triangles.begin();
    const auto count = std::ptrdiff_t(ball.triangles.size() / kPieces);
    pieces[p].triangles.assign(
        begin + std::ptrdiff_t(p) * count,
        p + 1 == kPieces ? ball.triangles.end() : begin + std::ptrdiff_t(p + 1) * count);
  }
  for (const Vec3d eye : {kFront.eye, Vec3d{0.2, 0.15, 0.02}}) {
    const Camera camera{.eye = eye, .target = {}};
    std::vector<RenderItem> small;
    for (const TriMesh& piece : pieces) small.push_back({.mesh = &piece, .color = kRed, .closed = true});
    const Image expected = draw(small, RenderQuality::kQuick, camera),
                found = draw({{.mesh = &ball, .color = kRed, .closed = true}}, RenderQuality::kQuick, camera);
    int different = 0;
    for (int y = 0; y < kHeight; y++)
      for (int x = 0; x < kWidth; x++) different += test::difference(found.at(x, y), expected.at(x, y)) > 0;
    EXPECT_EQ(different, 0);
  }
}

// A quick picture of a subdivided ball shows the triangles before the last subdivision if it would show very
// many: far away, but not close to its skin, and not in full quality.
TEST_F(MeshItems, ManySubdividedTrianglesAreShownByFours) {
  const TriMesh coarse = test::sphere({}, 0.15f, 96);
  const SmoothSurface surface = loop_subdivision(coarse.triangles, 1);
  TriMesh ball;
  const std::span<const Vec3> points(coarse.vertices);
  for (std::size_t v = 0; v < surface.size(); v++) {
    const Vec3 x = interpolated(surface, v, points);
    ball.vertices.push_back(x * (1 + 0.02f * std::sin(1500 * x.x) * std::sin(1500 * x.z)));
  }
  ball.triangles = surface.triangles;
  ball.normals = vertex_normals(ball);
  ASSERT_GT(ball.triangles.size(), 130'000u);
  TriMesh before = ball;
  before.triangles.clear();
  for (std::size_t t = 0; t < ball.triangles.size(); t += 4)
    before.triangles.push_back(triangle_of_four(&ball.triangles[t]));
  const auto different = [&](const TriMesh& other, Vec3d eye, RenderQuality quality) {
    const Camera camera{.eye = eye, .target = {}};
    const Image expected = draw({{.mesh = &other, .color = kRed, .closed = true}}, quality, camera),
                found =
                    draw({{.mesh = &ball, .color = kRed, .in_fours = true, .closed = true}}, quality, camera);
    int count = 0;
    for (int y = 0; y < kHeight; y++)
      for (int x = 0; x < kWidth; x++) count += test::difference(found.at(x, y), expected.at(x, y)) > 0;
    return count;
  };
  const Vec3d near{0, -0.19, 0};
  EXPECT_EQ(different(before, kFront.eye, RenderQuality::kQuick), 0);
  EXPECT_GT(different(ball, kFront.eye, RenderQuality::kQuick), 100) << "the waves are finer";
  EXPECT_EQ(different(ball, near, RenderQuality::kQuick), 0);
  EXPECT_EQ(different(ball, kFront.eye, RenderQuality::kFull), 0);
}

// A plane removes the part of a hollow ball on its outer side; the section is a disk or a ring.
TEST_F(MeshItems, PlaneCutsBall) {
  for (const auto& [normal, distance, hollow] :
       {std::tuple(Vec3d{0.3, -0.8, 0.5}, 0.02, 0.11), {Vec3d{-0.6, -0.7, -0.1}, 0.07, 0.03}})
    for (const RenderQuality quality : {RenderQuality::kFull, RenderQuality::kQuick}) {
      const TriMesh ball = hollow_ball(0.15f, float(hollow));
      const Cutaway cutaway{1, {plane_at(normal, distance)}};
      expect_section(draw(cut_ball(ball, cutaway), quality), cutaway, 0.15, hollow);
    }
}

// A picture on the face covers it, with its first row at the bottom; left is red and right is green.
TEST_F(MeshItems, FaceShowsItsPicture) {
  const TriMesh ball = test::sphere({}, 0.15f, 96);
  constexpr Camera front{.eye = {0, -1, 0}, .target = {0, 0, 0}};
  std::vector<RenderItem> items = cut_ball(ball, {1, {plane_at({0, -1, 0}, 0)}});
  Image picture = make_image(4, 2, kRed);
  for (const int x : {2, 3}) picture.at(x, 0) = picture.at(x, 1) = kGreen;
  for (int x = 0; x < 4; x++) picture.at(x, 0) = {20, 20, 220};
  // pixels of 0.1 m around the middle of the ball
  items[1].color = {200, 200, 200};
  items[1].face_pictures = {
      {.corner = {-0.15, 0, -0.05}, .right = {0.1, 0, 0}, .up = {0, 0, 0.1}, .image = picture}};
  for (const RenderQuality quality : {RenderQuality::kFull, RenderQuality::kQuick}) {
    const Image image = draw(items, quality, front);
    const auto at = [&](double x, double z) {
      const double scale = 0.5 * kHeight / (camera_frame(front).tan_half * norm(front.eye));
      return image.at(int(0.5 * kWidth + scale * x), int(0.5 * kHeight - scale * z));
    };
    EXPECT_TRUE(test::is_red(at(-0.08, 0.06)));
    EXPECT_TRUE(test::is_green(at(0.08, 0.06)));
    for (const double x : {-0.08, 0.08}) {
      const Rgb low = at(x, -0.08);
      EXPECT_TRUE(low.b > 2 * low.r && low.b > 2 * low.g) << int(low.r) << " " << int(low.g);
    }
  }
}

// Two planes remove a wedge only, and both of its faces are drawn.
TEST_F(MeshItems, WedgeCutsBall) {
  const Cutaway wedge{2, {plane_at({0.9, -0.5, 0.1}, 0.01), plane_at({-0.5, -0.4, 0.7}, -0.02)}};
  for (const double hollow : {0.02, 0.09})
    for (const RenderQuality quality : {RenderQuality::kFull, RenderQuality::kQuick}) {
      const TriMesh ball = hollow_ball(0.15f, float(hollow));
      expect_section(draw(cut_ball(ball, wedge), quality), wedge, 0.15, hollow);
    }
}

// A body that the plane leaves whole, or removes, looks as without cut-away, or not at all.
TEST_F(MeshItems, PlaneBesideBall) {
  const TriMesh ball = test::sphere({}, 0.15f);
  const Image whole = draw({{.mesh = &ball, .color = kRed, .closed = true}});
  const auto changed = [&](const Image& image, const Image& other) {
    return test::find_pixels(
               image, [&](int x, int y) { return test::difference(image.at(x, y), other.at(x, y)) > 8; })
        .count;
  };
  const Image kept = draw(cut_ball(ball, {1, {plane_at({0, -1, 0}, 0.2)}}));
  EXPECT_LE(changed(kept, whole), 20);
  EXPECT_EQ(changed(draw(cut_ball(ball, {1, {plane_at({0, -1, 0}, -0.2)}})), draw({})), 0);
}

// The section of one body hides what is behind it, and a body inside that is not cut stands out of it.
TEST_F(MeshItems, FaceHidesWhatIsBehind) {
  const TriMesh ball = test::sphere({}, 0.15f), nodule = test::sphere({0, 0, 0}, 0.04f),
                deep = test::sphere({0.08f, 0.06f, 0}, 0.03f);
  const Cutaway half{1, {plane_at({0, -1, 0}, 0)}};
  std::vector<RenderItem> items = cut_ball(ball, half);
  items.push_back({.mesh = &deep, .color = {20, 20, 220}});
  items.push_back({.mesh = &nodule, .color = {20, 20, 220}});
  const auto blue = [](Rgb c) { return c.b > 2 * c.r && c.b > 2 * c.g && c.b > 40; };
  const Image image = draw(items);
  const auto found = test::find_pixels(image, [&](int x, int y) { return blue(image.at(x, y)); });
  const double expected = test::silhouette_area(kFront, 0.04, kHeight);
  EXPECT_NEAR(found.count, expected, 0.04 * expected);
}

// The section of an inclusion lies over that of its body.
TEST_F(MeshItems, LaterFaceIsOnTop) {
  const TriMesh ball = test::sphere({}, 0.15f), nodule = test::sphere({0, 0, 0}, 0.05f, 96);
  const Cutaway half{1, {plane_at({0.2, -1, 0.1}, 0)}};
  std::vector<RenderItem> items = {{.mesh = &ball, .color = {20, 20, 220}, .closed = true, .cutaway = half},
                                   {.mesh = &ball, .color = kRed, .cutaway = half, .is_cut_face = true},
                                   {.mesh = &nodule, .color = kGreen, .cutaway = half, .is_cut_face = true}};
  for (const RenderQuality quality : {RenderQuality::kFull, RenderQuality::kQuick}) {
    const Image image = draw(items, quality);
    const auto green =
        test::find_pixels(image, [&](int x, int y) { return shown_by(image.at(x, y)) == Shown::kFace; });
    const CameraFrame frame = camera_frame(kFront);
    int expected = 0;  // rays through the disk of the nodule
    for (int y = 0; y < kHeight; y++)
      for (int x = 0; x < kWidth; x++) {
        const double u = (2 * (x + 0.5) - kWidth) / kHeight, v = 1 - 2 * (y + 0.5) / kHeight;
        const Vec3d ray = (frame.right * u + frame.up * v) * frame.tan_half - frame.back;
        const Vec3d n = half.plane[0].outward;
        expected += norm(kFront.eye - ray * (dot(kFront.eye, n) / dot(ray, n))) < 0.05;
      }
    EXPECT_NEAR(green.count, expected, 0.04 * expected);
  }
}

// The removed part casts no shadow.
TEST_F(MeshItems, RemovedPartCastsNoShadow) {
  constexpr Camera above{.eye = {0, -0.001, 0.5}, .target = {}, .up = {0, 1, 0}};
  const TriMesh floor{{{-0.3f, -0.3f, 0}, {0.3f, -0.3f, 0}, {0.3f, 0.3f, 0}, {-0.3f, 0.3f, 0}},
                      {{0, 1, 2}, {0, 2, 3}},
                      {},
                      {}},
      ball = test::sphere({0, 0, 0.03f}, 0.02f);
  const auto in_shadow = [&](Cutaway cutaway) {
    const Image image = draw({{.mesh = &floor}, {.mesh = &ball, .closed = true, .cutaway = cutaway}},
                             RenderQuality::kFull, above);
    const Vec3d pixel = test::project(above, {0.033, -0.035, 0}, kWidth, kHeight);
    return int(image.at(int(pixel.x), int(pixel.y)).g);
  };
  const int shadow = in_shadow({}), without = in_shadow({1, {{{0, 0, 0.005}, {0, 0, 1}}}});
  EXPECT_LT(shadow + 40, without);
}

}  // namespace
}  // namespace turgor

#include "turgor/view/wet_reflection.hpp"

#include <initializer_list>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/view/shapes.hpp"
#include "turgor/view/lights.hpp"

namespace turgor {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kWidth = 400, kHeight = 300;
constexpr Camera kFront{.eye = {0, -1, 0}, .target = {0, 0, 0}};

/// Integral of the film's reflectance over all lights above the surface, with half vectors as variables: the
/// solid angle of the light is 4 (v·h) times that of the half vector.
double film_reflectance(double nv) {
  WetReflection wet;
  constexpr int kRings = 600, kTurns = 400;
  const double vx = std::sqrt(1 - nv * nv);
  double sum = 0;
  for (int i = 0; i < kRings; i++)
    for (int j = 0; j < kTurns; j++) {
      const double polar = (i + 0.5) / kRings * kPi / 2, turn = (j + 0.5) / kTurns * kPi;
      const double nh = std::cos(polar), vh = std::sin(polar) * std::cos(turn) * vx + nh * nv;
      const double nl = 2 * vh * nh - nv;
      if (vh <= 1e-6 || nl <= 1e-6) continue;
      const double angle = std::sin(polar) * (kPi / 2 / kRings) * (2 * kPi / kTurns);
      sum += double(wet.wet_film(float(nh), float(nl), float(nv), float(vh))) * nl * 4 * vh * angle;
    }
  return sum;
}

/// Light of a white base from surroundings of radiance 1: the wrapped cosine over the whole sphere, over π.
double base_reflectance(double nv, float wrap) {
  WetReflection wet;
  double sum = 0;
  constexpr int kSteps = 4000;
  for (int i = 0; i < kSteps; i++)
    sum += 2.0 / kSteps * 2 * double(wet.wet_wrapped(float(-1 + (i + 0.5) * 2 / kSteps), wrap));
  return sum * double(wet.wet_base(float(nv)));
}

// White furnace: in surroundings of radiance 1 a white surface sends out at most 1 in every direction.
TEST(WetReflection, ReflectsNoMoreThanItReceives) {
  for (const double nv : {0.03, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.97, 1.0})
    for (const float wrap : {0.0f, 0.15f, 0.32f}) {
      const double film = film_reflectance(nv), base = base_reflectance(nv, wrap);
      EXPECT_NEAR(base, double(WetReflection().wet_base(float(nv))), 1e-3) << "all light that enters leaves";
      EXPECT_LE(film + base, 1) << nv;
      EXPECT_GT(film + base, nv > 0.4 ? 0.9 : 0.4) << nv << ": little is lost";
    }
}

// At normal incidence the film reflects Fresnel's share of water, and the fit follows the integral.
TEST(WetReflection, ReflectsFresnelShare) {
  EXPECT_NEAR(film_reflectance(1), std::pow(0.333 / 2.333, 2), 1.5e-3);
  for (const double nv : {0.1, 0.25, 0.4, 0.6, 0.8, 1.0})
    EXPECT_NEAR(double(WetReflection().wet_surroundings(float(nv))), film_reflectance(nv), 0.03) << nv;
}

// The film's distribution is the same if light and view are exchanged.
TEST(WetReflection, IsReciprocal) {
  WetReflection wet;
  for (const float nh : {0.7f, 0.95f, 1.0f})
    for (const float nl : {0.2f, 0.6f})
      EXPECT_FLOAT_EQ(wet.wet_film(nh, nl, 0.9f, 0.7f), wet.wet_film(nh, 0.9f, nl, 0.7f));
}

class WetSurfaces : public testing::Test {
 protected:
  void SetUp() override {
    const TriMesh mesh = test::sphere({}, 0.1f, 4);
    if (const Result<Image> image = draw_meshes({{.mesh = &mesh}}, kFront, 8, 8); !image)
      GTEST_SKIP() << image.error().message;
  }
  static Image draw(const std::vector<RenderItem>& items, const Camera& camera = kFront) {
    const Result<Image> image = draw_meshes(items, camera, kWidth, kHeight);
    EXPECT_TRUE(image);
    return *image;
  }
};

constexpr Rgb kDark{120, 20, 20};

/// Light of a wet surface by the formulas above, for normals that no shadow or hollow darkens.
Rgb wet_color(Rgb color, Vec3 n, Vec3 view, const Lights& lights) {
  WetReflection wet;
  const auto albedo = [](std::uint8_t c) { return std::pow(float(c) / 255, 2.2f); };
  const auto film = [&](Vec3 light) {
    const Vec3 h = normalized(light + view);
    const float nl = std::max(0.0f, dot(n, light)), nv = dot(n, view);
    return float(kPi) * nl * wet.wet_film(std::max(0.0f, dot(n, h)), nl, nv, dot(view, h));
  };
  const auto around = [&](float height) {
    return lights.floor_color + (lights.sky_color - lights.floor_color) * (0.5f + 0.5f * height);
  };
  const Vec3 base{albedo(color.r), albedo(color.g), albedo(color.b)}, wrap{0.32f, 0.2f, 0.15f};
  const Vec3 mirrored = n * (2 * dot(n, view)) - view;
  const Vec3 lit = lights.fill_color * std::max(0.0f, dot(n, lights.fill)) + around(dot(n, lights.up));
  Vec3 light = lights.key_color * film(lights.key) + lights.fill_color * film(lights.fill) +
               lights.rim_color * film(lights.rim) +
               around(dot(mirrored, lights.up)) * wet.wet_surroundings(dot(n, view));
  for (int c = 0; c < 3; c++)
    light[c] += base[c] * wet.wet_base(dot(n, view)) *
                (lit[c] + lights.key_color[c] * wet.wet_wrapped(dot(n, lights.key), wrap[c]));
  return screen_color(light);
}

// Pixels of a wet ball have the light that the formulas give, in the highlight and beside it.
TEST_F(WetSurfaces, BallMatchesFormulas) {
  const double radius = 0.15;
  const TriMesh ball = test::sphere({}, float(radius), 160);
  const Image image = draw({{.mesh = &ball, .color = kDark, .closed = true, .wet = true}});
  const CameraFrame frame = camera_frame(kFront);
  const Lights lights = camera_lights(frame);
  const Vec3d half = normalized(Vec3d(lights.key) + frame.back);
  for (const Vec3d toward : {half, half + frame.right * 0.06, half - frame.up * 0.15, frame.back,
                             frame.back + frame.right * 0.3, frame.back - frame.right * 0.5}) {
    const Vec3d n = normalized(toward), x = n * radius, pixel = test::project(kFront, x, kWidth, kHeight);
    // the normal of the pixel's center
    const double u = (2 * (int(pixel.x) + 0.5) - kWidth) / kHeight,
                 v = 1 - 2 * (int(pixel.y) + 0.5) / kHeight;
    const Vec3d ray = normalized((frame.right * u + frame.up * v) * frame.tan_half - frame.back);
    const double b = dot(kFront.eye, ray), c = dot(kFront.eye, kFront.eye) - radius * radius;
    const Vec3d hit = kFront.eye + ray * (-b - std::sqrt(b * b - c));
    const Rgb expected = wet_color(kDark, Vec3(normalized(hit)), Vec3(-ray), lights);
    EXPECT_LE(test::difference(image.at(int(pixel.x), int(pixel.y)), expected), 15)
        << int(expected.r) << " " << int(expected.g) << " " << int(expected.b);
  }
}

/// Brightest green value of a dark red ball, and the number of pixels in the upper half of its highlight.
std::pair<int, int> highlight(const Image& image) {
  std::vector<int> greens;
  for (int y = 0; y < kHeight; y++)
    for (int x = 0; x < kWidth; x++) {
      const Vec3d at{(x + 0.5 - kWidth / 2.0), (y + 0.5 - kHeight / 2.0), 0};
      if (norm(at) < 60) greens.push_back(image.at(x, y).g);
    }
  std::sort(greens.begin(), greens.end());
  const int peak = greens.back(), half = (peak + greens[greens.size() / 2]) / 2;
  return {peak, int(greens.end() - std::upper_bound(greens.begin(), greens.end(), half))};
}

// The highlight of a wet ball is brighter and narrower than that of a dry one.
TEST_F(WetSurfaces, HighlightIsBrighterAndNarrower) {
  const TriMesh ball = test::sphere({}, 0.15f, 96);
  const auto [dry_peak, dry_size] = highlight(draw({{.mesh = &ball, .color = kDark}}));
  const auto [wet_peak, wet_size] = highlight(draw({{.mesh = &ball, .color = kDark, .wet = true}}));
  EXPECT_GT(wet_peak, dry_peak + 40);
  EXPECT_LT(wet_size, 0.7 * dry_size);
  EXPECT_GT(wet_size, 20);
}

// Shadows and hollows darken a wet floor, and its highlights, too.
TEST_F(WetSurfaces, ShadowAndOcclusionDarken) {
  constexpr Camera above{.eye = {0, -0.001, 0.5}, .target = {}, .up = {0, 1, 0}};
  const TriMesh floor{{{-0.3f, -0.3f, 0}, {0.3f, -0.3f, 0}, {0.3f, 0.3f, 0}, {-0.3f, 0.3f, 0}},
                      {{0, 1, 2}, {0, 2, 3}},
                      {},
                      {}},
      ball = test::sphere({0, 0, 0.03f}, 0.02f),
      wall{{{0.05f, -0.3f, 0}, {0.05f, 0.3f, 0}, {0.05f, 0.3f, 0.06f}, {0.05f, -0.3f, 0.06f}},
           {{0, 1, 2}, {0, 2, 3}},
           {},
           {}};
  const auto brightness = [&](const Image& image, Vec3d point) {
    const Vec3d pixel = test::project(above, point, kWidth, kHeight);
    return int(image.at(int(pixel.x), int(pixel.y)).g);
  };
  const Image plain = draw({{.mesh = &floor, .wet = true}}, above),
              shaded = draw({{.mesh = &floor, .wet = true}, {.mesh = &ball}}, above),
              hollow = draw({{.mesh = &floor, .wet = true}, {.mesh = &wall, .wet = true}}, above);
  EXPECT_LT(brightness(shaded, {0.033, -0.035, 0}) + 40, brightness(plain, {0.033, -0.035, 0}));
  EXPECT_LT(brightness(hollow, {0.047, 0, 0}), 0.95 * brightness(plain, {0.047, 0, 0}));
}

// Colors that show values are not changed by highlights of a film, and a wet body leaves others as they are.
TEST_F(WetSurfaces, MappedAndOtherBodiesStayDry) {
  TriMesh left = test::sphere({-0.1f, 0, 0}, 0.09f);
  const TriMesh right = test::sphere({0.1f, 0, 0}, 0.09f);
  const ColorScale scale{.low = 0, .high = 2, .label = "", .factor = 1};
  left.scalars.assign(left.vertices.size(), 1.0f);
  const Image dry = draw({{.mesh = &left, .scale = &scale}, {.mesh = &right, .color = kDark}}),
              wet = draw({{.mesh = &left, .scale = &scale, .wet = true}, {.mesh = &right, .color = kDark}}),
              other = draw({{.mesh = &left, .scale = &scale}, {.mesh = &right, .color = kDark, .wet = true}});
  EXPECT_EQ(dry.pixels, wet.pixels);
  const auto changed = test::find_pixels(dry, [&](int x, int y) { return dry.at(x, y) != other.at(x, y); });
  EXPECT_GT(changed.count, 1000);
  EXPECT_GT(changed.x, test::project(kFront, {0.08, 0, 0}, kWidth, kHeight).x);
}

}  // namespace
}  // namespace turgor

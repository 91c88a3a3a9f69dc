// One contact site alone, solved exactly: open, sticking, or sliding with its slip direction as the unknown.
#include <algorithm>
#include <cmath>

#include "turgor/contact/coulomb.hpp"

namespace turgor::contact {

namespace {

struct Vec2 {
  double x = 0, y = 0;
};
double dot(Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; }

/// Where a sliding site is looked for: with c_n = 0 the tangential force is λ_t = −(S + αI)⁻¹ r, α ≥ 0 being
/// slip over force, and λ_n = λ_0 + g·λ_t. All in the axes of S, which are s.x and s.y.
struct Slide {
  Vec2 s, r, g;
  double normal_force = 0;  // λ_0
  double friction = 0;
  Mat3d axes;  // of S: columns y and z; x is the normal

  Vec2 tangential(double alpha) const { return {-r.x / (s.x + alpha), -r.y / (s.y + alpha)}; }
  double normal(Vec2 t) const { return normal_force + dot(g, t); }
  /// |λ_t| − μ λ_n, and how it changes with α.
  double excess(double alpha, double& derivative) const {
    const Vec2 t = tangential(alpha), dt{-t.x / (s.x + alpha), -t.y / (s.y + alpha)};
    const double length = std::sqrt(dot(t, t));
    derivative = (length > 0 ? dot(t, dt) / length : 0) - friction * dot(g, dt);
    return length - friction * normal(t);
  }
};

/// The axes of a symmetric 2×2 matrix (a b; b c): its first one is (cos, sin).
Vec2 first_axis(double a, double b, double c) {
  if (b == 0) return {1, 0};
  const double half = (a - c) / 2, root = std::hypot(half, b);
  const Vec2 v = half >= 0 ? Vec2{half + root, b} : Vec2{b, root - half};
  const double length = std::hypot(v.x, v.y);
  return {v.x / length, v.y / length};
}

Slide make_slide(const double (&d)[9], Vec3d b, double friction) {
  const double nn = d[0];
  const Vec2 tn{d[1], d[2]};
  const double s00 = d[4] - tn.x * tn.x / nn, s01 = d[5] - tn.x * tn.y / nn, s11 = d[8] - tn.y * tn.y / nn;
  const Vec2 r{b.y - tn.x * b.x / nn, b.z - tn.y * b.x / nn};
  const Vec2 e = first_axis(s00, s01, s11), f{-e.y, e.x};
  Slide slide;
  slide.s = {s00 * e.x * e.x + 2 * s01 * e.x * e.y + s11 * e.y * e.y,
             s00 * f.x * f.x + 2 * s01 * f.x * f.y + s11 * f.y * f.y};
  slide.r = {dot(r, e), dot(r, f)};
  slide.g = {-dot(tn, e) / nn, -dot(tn, f) / nn};
  slide.normal_force = -b.x / nn;
  slide.friction = friction;
  slide.axes = {{{1, 0, 0}, {0, e.x, e.y}, {0, f.x, f.y}}};
  return slide;
}

/// The force where the excess vanishes. It is positive at α = 0 (the site does not stick) and negative for
/// large α, where only the normal force is left; Newton steps, halved intervals where they leave the bracket.
Vec3d solve_slide(const Slide& slide) {
  double low = 0, high = slide.s.x + slide.s.y, derivative = 0;
  while (slide.excess(high, derivative) > 0) low = high, high *= 4;
  constexpr int kMostSteps = 100;
  double alpha = low;
  for (int step = 0; step < kMostSteps; step++) {
    const double excess = slide.excess(alpha, derivative);
    (excess > 0 ? low : high) = alpha;
    double next = alpha - excess / derivative;
    if (std::abs(next - alpha) <= 1e-15 * alpha) break;
    if (!(next > low && next < high)) next = (low + high) / 2;
    alpha = next;
  }
  const Vec2 t = slide.tangential(alpha);
  const double n = std::max(0.0, slide.normal(t)), length = std::sqrt(dot(t, t));
  const double on_cone = length > 0 ? slide.friction * n / length : 0;
  return slide.axes * Vec3d{n, on_cone * t.x, on_cone * t.y};
}

}  // namespace

SiteSolution solve_site(const double (&d)[9], Vec3d b, double friction) {
  if (b.x >= 0) return {};
  if (friction <= 0) return {{-b.x / d[0], 0, 0}, SiteState::kSlip};
  const Vec3d stick = -(inverse(Mat3d{{{d[0], d[1], d[2]}, {d[3], d[4], d[5]}, {d[6], d[7], d[8]}}}) * b);
  if (stick.x >= 0 && stick.y * stick.y + stick.z * stick.z <= friction * friction * stick.x * stick.x)
    return {stick, SiteState::kStick};
  return {solve_slide(make_slide(d, b, friction)), SiteState::kSlip};
}

}  // namespace turgor::contact

// Exact solution of one contact site: open, sticking, or sliding with the ratio of slip to force as the
// unknown.
#include <algorithm>
#include <cmath>

#include "turgor/contact/coulomb.hpp"
#include "turgor/core/assert.hpp"

namespace turgor::contact {

namespace {

struct Vec2 {
  double x = 0, y = 0;
};
double dot(Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; }

/// First eigenvector of a symmetric 2×2 matrix (a b; b c).
Vec2 first_axis(double a, double b, double c) {
  if (b == 0) return {1, 0};
  const double half = (a - c) / 2, root = std::sqrt(half * half + b * b);
  const Vec2 v = half >= 0 ? Vec2{half + root, b} : Vec2{b, root - half};
  const double length = std::sqrt(dot(v, v));
  return {v.x / length, v.y / length};
}

/// Equations of a sliding site. With c_n = 0, the tangential force is λ_t = −(S + αI)⁻¹ r, where α ≥ 0 is
/// slip over force, and λ_n = λ_0 + g·λ_t. All in the axes of S.
struct Slide {
  Vec2 s, r, g;
  double normal_force = 0;  // λ_0
  double friction = 0;

  Vec2 tangential(double alpha) const { return {-r.x / (s.x + alpha), -r.y / (s.y + alpha)}; }
  double normal(Vec2 t) const { return normal_force + dot(g, t); }
  /// μ λ_n / |λ_t| − 1: negative outside of the cone, nearly linear in α.
  double cone_margin(double alpha, double& derivative) const {
    const Vec2 t = tangential(alpha), dt{-t.x / (s.x + alpha), -t.y / (s.y + alpha)};
    const double squared = dot(t, t), length = std::sqrt(squared), n = normal(t);
    derivative = friction / length * (dot(g, dt) - n * dot(t, dt) / squared);
    return friction * n / length - 1;
  }
};

Slide make_slide(const SiteCompliance& law, Vec3d b, double friction) {
  const Vec2 e{law.axis[0], law.axis[1]}, f{-e.y, e.x};
  const double nn = law.d.column[0].x;
  const Vec2 tn{law.d.column[0].y / nn, law.d.column[0].z / nn};
  const Vec2 r{b.y - tn.x * b.x, b.z - tn.y * b.x};
  return {.s = {law.s[0], law.s[1]},
          .r = {dot(r, e), dot(r, f)},
          .g = {-dot(tn, e), -dot(tn, f)},
          .normal_force = -b.x / nn,
          .friction = friction};
}

/// Force on the friction cone, where cone_margin is 0. It is outside of the cone at α = 0, because the site
/// does not stick, and inside for large α, where only the normal force remains. Newton steps, with bisection
/// when they leave the bracket.
Vec3d solve_slide(SiteCompliance& law, const Slide& slide) {
  double low = 0, high = HUGE_VAL, alpha = law.slip;
  TURGOR_CHECK(slide.friction > 0 && law.slip >= 0,
               "a site slides with friction, in the direction of its force");
  constexpr int kMaxSteps = 100;
  for (int step = 0; step < kMaxSteps; step++) {
    double derivative = 0;
    const double cone_margin = slide.cone_margin(alpha, derivative);
    (cone_margin < 0 ? low : high) = alpha;
    double next = alpha - cone_margin / derivative;
    const bool near =
        std::abs(next - alpha) <= 1e-8 * alpha;  // the error of the next value is the square of this
    if (!(next >= low && next <= high))
      next = high < HUGE_VAL ? (low + high) / 2 : 4 * alpha + slide.s.x + slide.s.y;
    alpha = next;
    if (near || cone_margin == 0) break;
  }
  law.slip = alpha;
  // force on the cone, in the site's frame
  const Vec2 t = slide.tangential(alpha);
  const double n = std::max(0.0, slide.normal(t)), length = std::sqrt(dot(t, t));
  const double on_cone = length > 0 ? slide.friction * n / length : 0;
  const Vec2 e{law.axis[0], law.axis[1]};
  return {n, on_cone * (t.x * e.x - t.y * e.y), on_cone * (t.x * e.y + t.y * e.x)};
}

}  // namespace

SiteCompliance make_law(const Mat3d& axes, const Mat3d& d) {
  TURGOR_CHECK(d.column[0].x > 0, "the compliance of a contact site is positive");
  SiteCompliance law{.axes = axes, .d = d, .inverse = inverse(d)};
  const auto& [n, y, z] = d.column;
  const double a = y.y - y.x * y.x / n.x, b = y.z - y.x * z.x / n.x, c = z.z - z.x * z.x / n.x;
  const Vec2 e = first_axis(a, b, c);
  law.s[0] = a * e.x * e.x + 2 * b * e.x * e.y + c * e.y * e.y;
  law.s[1] = a * e.y * e.y - 2 * b * e.x * e.y + c * e.x * e.x;
  law.axis[0] = e.x, law.axis[1] = e.y;
  return law;
}

SiteSolution solve_site(SiteCompliance& law, Vec3d b, double friction) {
  // open
  if (b.x >= 0) return {};
  // frictionless
  if (friction <= 0) return {{-b.x / law.d.column[0].x, 0, 0}, SiteState::kSlip};
  // sticking, if within the cone
  const Vec3d stick = -(law.inverse * b);
  if (stick.x >= 0 && stick.y * stick.y + stick.z * stick.z <= friction * friction * stick.x * stick.x)
    return {stick, SiteState::kStick};
  // sliding
  return {solve_slide(law, make_slide(law, b, friction)), SiteState::kSlip};
}

}  // namespace turgor::contact

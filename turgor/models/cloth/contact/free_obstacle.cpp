#include "turgor/models/cloth/contact/free_obstacle.hpp"

#include <Eigen/Dense>

#include "turgor/core/assert.hpp"
#include "turgor/core/invariants.hpp"

namespace turgor::cloth {

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

Eigen::Vector3d eigen_of(Vec3d v) { return {v.x, v.y, v.z}; }
Vec3d vec_of(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// M
Matrix6 inertia_matrix(const FreeInertia& inertia) {
  Matrix6 m = Matrix6::Zero();
  for (int k = 0; k < 3; k++) {
    m(k, k) = inertia.mass;
    m.block<3, 1>(3, 3 + k) = eigen_of(inertia.inertia.column[k]);
  }
  return m;
}

/// J of an arm: the velocity of a point by those of the body.
Eigen::Matrix<double, 3, 6> motion_at(Vec3d arm) {
  Eigen::Matrix<double, 3, 6> j;
  j.leftCols<3>().setIdentity();
  for (int k = 0; k < 3; k++) {
    Vec3d axis;
    axis[k] = 1;
    j.col(3 + k) = eigen_of(cross(axis, arm));
  }
  return j;
}

/// Velocity of a point.
Vec3d motion_of(Vec3d velocity, Vec3d spin, Vec3d arm) { return velocity + cross(spin, arm); }

/// Sum of Jᵀ P.
struct Wrench {
  Vec3d impulse, moment;

  void add(Vec3d p, Vec3d arm) { impulse += p, moment += cross(arm, p); }
};

/// −(M + B)⁻¹ of a wrench: change of the velocities of the body.
struct Motion {
  Vec3d velocity, spin;
};
Motion motion_under(const FreeObstacle& free, const Wrench& wrench) {
  Vector6 right;
  right << eigen_of(wrench.impulse), eigen_of(wrench.moment);
  const Vector6 q = -(Eigen::Map<const Matrix6>(free.inverse.data()) * right);
  return {vec_of(q.head<3>()), vec_of(q.tail<3>())};
}

/// L + M q, with the change q of the body's velocities so far.
Wrench given_wrench(const FreeObstacle& free, double dt) {
  const FreeInertia& inertia = free.inertia;
  return {inertia.force * dt + free.velocity * inertia.mass,
          inertia.torque * dt + inertia.inertia * free.spin};
}

/// visit(contact, terms) for every contact of an obstacle.
template <class Contacts, class Visit>
void for_each_contact(Contacts& implicit, int obstacle, const Visit& visit) {
  for (std::size_t n = 0; n < implicit.terms.size(); n++)
    if (implicit.contacts.list[n].obstacle == obstacle) visit(implicit.contacts.list[n], implicit.terms[n]);
}

bool is_closed(const ImplicitContact& terms) { return terms.normal_stiffness > 0; }

}  // namespace

void find_free_obstacles(const Inputs& inputs, State& state) {
  ImplicitContacts& implicit = state.implicit_contacts;
  implicit.free.clear();
  for (std::size_t o = 0; o < inputs.obstacles.size(); o++) {
    const Obstacle& obstacle = inputs.obstacles[o];
    if (!obstacle.free) continue;
    // inertia against the impulses of a step that is shorter than the frame
    FreeObstacle free{.obstacle = int(o), .inertia = *obstacle.free};
    TURGOR_CHECK(free.inertia.mass > 0 && is_step_length(free.inertia.frame), "a free obstacle has a mass");
    const double share = state.impulse_time / free.inertia.frame;
    free.inertia.mass *= share;
    for (Vec3d& column : free.inertia.inertia.column) column *= share;
    // arms to its surface
    bool touches = false;
    for_each_contact(implicit, int(o), [&](const Contact& c, ImplicitContact& terms) {
      Vec3d point;
      for (std::size_t k = 0; k < 4; k++)
        if (c.vertex[k] >= 0) point += Vec3d(state.x[std::size_t(c.vertex[k])]) * double(c.weight[k]);
      point -= Vec3d(c.normal) * (double(c.gap) + obstacle.gap);
      terms.arm = Vec3(point - free.inertia.center);
      touches = true;
    });
    if (touches) implicit.free.push_back(free);
  }
}

void factor_free_obstacles(State& state) {
  ImplicitContacts& implicit = state.implicit_contacts;
  for (FreeObstacle& free : implicit.free) {
    Matrix6 sum = inertia_matrix(free.inertia);
    for_each_contact(implicit, free.obstacle, [&](const Contact& c, const ImplicitContact& terms) {
      if (!is_closed(terms)) return;
      const Eigen::Matrix<double, 3, 6> j = motion_at(Vec3d(terms.arm));
      const Vector6 along = j.transpose() * eigen_of(Vec3d(c.normal));
      const double kt = double(terms.tangential_stiffness), kn = double(terms.normal_stiffness);
      sum += (kn - kt) * along * along.transpose() + kt * j.transpose() * j;
    });
    Eigen::Map<Matrix6>(free.inverse.data()) = sum.llt().solve(Matrix6::Identity());
  }
}

void yield_free_obstacles(bool with_loads, State& state) {
  ImplicitContacts& implicit = state.implicit_contacts;
  for (const FreeObstacle& free : implicit.free) {
    // velocity of the body
    Wrench wrench = with_loads ? given_wrench(free, state.impulse_time) : Wrench{};
    for_each_contact(implicit, free.obstacle, [&](const Contact& c, const ImplicitContact& terms) {
      if (is_closed(terms)) wrench.add(Vec3d(c.impulse_delta), Vec3d(terms.arm));
    });
    const Motion q = motion_under(free, wrench);
    // what its motion adds to the impulses
    for_each_contact(implicit, free.obstacle, [&](Contact& c, const ImplicitContact& terms) {
      if (!is_closed(terms)) return;
      const Vec3 yielded(motion_of(q.velocity, q.spin, Vec3d(terms.arm)));
      c.impulse_delta -= resisting_impulse(c, terms, yielded);
    });
  }
}

void move_free_obstacles(State& state) {
  ImplicitContacts& implicit = state.implicit_contacts;
  for (FreeObstacle& free : implicit.free) {
    // velocity of the body
    Wrench wrench = given_wrench(free, state.impulse_time);
    for_each_contact(implicit, free.obstacle, [&](const Contact& c, const ImplicitContact& terms) {
      if (!is_closed(terms)) return;
      Vec3 u;
      for (std::size_t k = 0; k < 4; k++)
        if (c.vertex[k] >= 0) u += state.system.change[std::size_t(c.vertex[k])] * c.weight[k];
      wrench.add(Vec3d(terms.load + resisting_impulse(c, terms, u)), Vec3d(terms.arm));
    });
    const Motion q = motion_under(free, wrench);
    free.velocity += q.velocity, free.spin += q.spin;
    // and of its surface
    for_each_contact(implicit, free.obstacle, [&](Contact& c, const ImplicitContact& terms) {
      c.obstacle_velocity += Vec3(motion_of(q.velocity, q.spin, Vec3d(terms.arm)));
    });
  }
}

ObstacleLoad free_obstacle_load(const State& state, int obstacle) {
  ObstacleLoad load;
  for_each_contact(state.implicit_contacts, obstacle,
                   [&](const Contact& found, const ImplicitContact& terms) {
                     // the impulse at the end of the step, of contacts that were kept
                     const Contact* c = find_previous(state.contacts, found);
                     if (c == nullptr) return;
                     const Vec3d impulse = impulse_on_obstacle(*c);
                     load.impulse += impulse, load.moment += cross(Vec3d(terms.arm), impulse);
                   });
  return load;
}

}  // namespace turgor::cloth

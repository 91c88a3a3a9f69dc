// Storage of contacts: the spatial hash that finds them, the contact list of one step, and the implicit
// contacts of the linear system. The functions are in contact/ and in solver/implicit_contact.hpp.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "turgor/core/vec.hpp"
#include "turgor/models/cloth/model/vectors.hpp"

namespace turgor::cloth {

/// Points sorted into hashed cells (contact/spatial_hash.hpp).
struct SpatialHash {
  Real cell = 0;  // edge length of a cell [m]
  std::uint32_t mask = 0;
  std::vector<int> begin;        // of each bucket, and the end
  std::vector<int> bucket;       // of each point
  std::vector<int> index;        // points by bucket
  aligned_vector<Real> x, y, z;  // positions by bucket, padded by one batch [m]
};

/// Contact of up to four vertices: two vertices, a vertex and a triangle, two edges, or a vertex or triangle
/// and an obstacle. The constraint is n·Σ w_k x_k ≥ plane.
struct Contact {
  std::array<int, 4> vertex{-1, -1, -1, -1};
  std::array<Real, 4> weight{};  // their sum is 0, or 1 against an obstacle
  int obstacle = -1;             // index in Inputs::obstacles; -1 = self-contact
  Vec3 normal;                   // unit, toward the first vertex
  Real gap = 0;    // how far the weighted sum may still move against the normal; negative: penetration [m]
  Real plane = 0;  // n·Σ w_k x_k at zero gap [m]
  Vec3 obstacle_velocity;    // velocity of the obstacle [m/s]
  Real friction = 0;         // Coulomb's coefficient [1]
  Real mass = 0;             // effective mass, with every vertex split among its contacts [kg]
  Real impulse = 0;          // normal impulse [N·s]
  Vec3 friction_impulse;     // tangential impulse [N·s]
  Real warm_start = 0;       // fraction of both impulses that the next step starts with [1]
  bool is_implicit = false;  // solved together with the sheet (solver/implicit_contact.hpp)
  Vec3 projected_impulse;    // impulse of the latest iteration before overrelaxation [N·s]
  Real position_impulse = 0,
       projected_position_impulse = 0;  // the same for positions, from 0 in each step [kg·m]
  Vec3 impulse_delta;                   // change of the impulse in the current iteration [N·s]
};

/// Contact list of a step, with the contacts of each vertex.
struct Contacts {
  std::vector<Contact> list;
  std::vector<int> begin, item;  // contacts of each vertex: item[begin[i]] … item[begin[i + 1] - 1]
  std::vector<int> touched;      // vertices with contacts, ascending
  std::vector<std::vector<Contact>> candidates;  // by chunk, before they are joined in `list`
  SpatialHash midpoint_hash;                     // of large edges
  Vectors midpoints;                             // of large edges, in their order [m]
  Real longest_half = 0;                         // half of the longest large edge [m]
  /// Pairs that passed the filters of the predicted search, by chunk: a large triangle and a vertex, or two
  /// large edges. The actual search of the same step begins at the same positions and tests these.
  std::vector<std::vector<std::array<int, 2>>> near_pairs;
  Real near_reach = 0;  // search distance of these pairs; 0 = they are not of this step [m]

  bool touches(int vertex) const {
    const auto v = std::size_t(vertex);
    return !begin.empty() && begin[v] < begin[v + 1];
  }
};

/// Terms of a contact in the linear system of a step. Its impulse is P = load − K u, with u the
/// weighted velocity change and K = k_n n nᵀ + k_t (I − n nᵀ).
struct ImplicitContact {
  Real normal_stiffness = 0;      // k_n [kg]; 0 = open
  Real tangential_stiffness = 0;  // k_t, of friction [kg]
  Real closed_stiffness = 0;      // k_n of the closed contact [kg]
  Real stick_stiffness = 0;       // k_t of the sticking contact [kg]
  Vec3 stick_impulse;             // friction impulse at zero tangential velocity [N·s]
  Vec3 load;                      // impulse at zero velocity change [N·s]
  Real separation_speed = 0;      // speed at which penetration is removed between two obstacles [m/s]
  Vec3 arm;                       // of a free obstacle: from its center to its surface at the contact [m]
};

/// Inertia of an obstacle that moves under the impulses of the cloth (contact/free_obstacle.hpp).
struct FreeInertia {
  Vec3d center;         // of mass at the beginning of the step [m]
  double mass = 0;      // [kg]
  Mat3d inertia;        // about the center, in the world [kg m²]
  Vec3d force, torque;  // load of the cloth that the velocity of the obstacle includes already [N] [N m]
  double frame = 0;     // time in which impulses act on it: the length of a frame [s]
};

/// Free obstacle in the linear system of a step. Its velocity changes by −(M + B)⁻¹ (S + L + M q).
struct FreeObstacle {
  int obstacle = -1;                 // index in Inputs::obstacles
  FreeInertia inertia;               // with masses for the impulses of the step
  std::array<double, 36> inverse{};  // (M + B)⁻¹, with B the stiffness of its closed contacts [1/kg …]
  Vec3d velocity, spin;              // q: change of its velocity by the solutions of the step [m/s] [rad/s]
};

/// Implicit contacts of the linear system, used by conjugate gradients.
struct ImplicitContacts {
  Contacts contacts;                   // vertex, weights, impulses
  std::vector<ImplicitContact> terms;  // terms of each contact
  std::vector<std::array<double, 6>>
      inverse;                     // inverse diagonal blocks of touched vertices without contact terms [1/kg]
  std::vector<FreeObstacle> free;  // obstacles that the cloth moves, ascending

  /// Tests whether any of the sixteen vertices from i on has an implicit contact.
  bool touches(std::size_t i) const {
    const auto& begin = contacts.begin;
    return !begin.empty() && i + 1 < begin.size() && begin[i] < begin[std::min(i + 16, begin.size() - 1)];
  }
};

}  // namespace turgor::cloth

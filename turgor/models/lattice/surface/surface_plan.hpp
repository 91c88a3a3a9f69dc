// Part of the deformation of a drawn surface that depends only on the surface and its cuts: the corners that
// move the vertices, the triangles around each vertex, the areas of the CT, and the ends of cuts.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "turgor/models/lattice/cutting/corner_terms.hpp"
#include "turgor/models/lattice/surface/crack_front.hpp"
#include "turgor/models/lattice/surface/cut_ends.hpp"
#include "turgor/models/lattice/surface/surface.hpp"

namespace turgor::lattice::detail {

/// Trilinear interpolation of a vertex from corners.
struct VertexCorners {
  std::array<int, 8> index;    // into SurfacePlan::corners
  std::array<Real, 8> weight;  // [1]
};

struct SurfacePlan {
  std::vector<int> corners;       // of all cells with a vertex, each once
  std::vector<int> term_begin;    // by corner, and the end: indices into `terms`; without terms, the corner
                                  // has a corner_displacement
  std::vector<CornerTerm> terms;  // of all corners
  std::vector<VertexCorners> of_vertex;
  std::vector<int> triangle_begin;  // by vertex, and the end: indices into `triangles`
  std::vector<int> triangles;       // around each vertex, ascending: 3 · triangle + corner
  std::vector<float> rest_area;     // twice the area in the CT, by skin triangle; 0 = degenerate [m²]
  std::vector<float> rest_around;   // sum of rest_area around each vertex [m²]
  FrontSides fronts;                // sides of walls near crack fronts
  CutEnds ends;

  std::span<const int> triangles_of(std::size_t v) const {
    const auto begin = std::size_t(triangle_begin[v]), end = std::size_t(triangle_begin[v + 1]);
    return std::span(triangles).subspan(begin, end - begin);
  }
};

/// Terms of corners that no cut and no removed node is near, from the first plan of a body. Later plans of
/// the body copy them.
struct KeptTerms {
  std::shared_ptr<const SurfacePlan> plan;  // null: none yet
  std::vector<int> index;                   // by slot: into plan->corners; −1 = not kept
};

/// Plan of a surface. `kept` saves time and does not change the plan; it is empty, or from an earlier call
/// with the same model.
std::shared_ptr<const SurfacePlan> make_surface_plan(const Exec& exec, const Model& model, const Cuts& cuts,
                                                     const BodySurface& surface, KeptTerms* kept = nullptr);

}  // namespace turgor::lattice::detail

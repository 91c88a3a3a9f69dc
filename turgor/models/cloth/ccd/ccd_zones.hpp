// Impact zones by vertex, by star and by box. Inside a zone nothing moves relatively, so a search after the
// first one visits its border only.
#pragma once

#include <cstddef>
#include <vector>

#include "turgor/core/exec.hpp"
#include "turgor/models/cloth/model/ccd_workspace.hpp"

namespace turgor::cloth {

struct Model;

constexpr std::size_t kLeaf = 32;  // vertices in the smallest motion boxes

std::size_t ccd_leaves(const Model& model);

/// Impact zone of each vertex, as the index of its smallest member; -1 = none. Empty without zones.
using ZoneOfVertex = std::vector<int>;

/// Joins the pairs from `first` on to zones; a zone is identified by its smallest member. `joined`: parent of
/// each vertex; -1 = in no pair.
void join_zones(CcdWorkspace& ccd, std::size_t first, std::vector<int>& joined);

ZoneOfVertex zone_of_vertices(const Model& model, const CcdWorkspace& ccd);

/// Zone of each vertex whose whole star is in one impact zone; else -1. Stars of the same zone do not move
/// relative to each other.
ZoneOfVertex zones_of_stars(const Exec& exec, const Model& model, const ZoneOfVertex& zone);

/// Zone of each motion box whose stars are all in one impact zone; else -1.
std::vector<int> zones_of_boxes(const Exec& exec, const Model& model, const CcdWorkspace& ccd,
                                const ZoneOfVertex& of_star);

}  // namespace turgor::cloth

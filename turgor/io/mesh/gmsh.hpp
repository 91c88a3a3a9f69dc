// What the readers of Gmsh's versions share. Each reads from behind the line that names a section up to the
// line that ends it. Internal to io/.
#pragma once

#include <map>

#include "turgor/io/mesh/solid_formats.hpp"

namespace turgor::io {

/// The element type of Gmsh's number; of unknown shape if there is none.
ElementType gmsh_type(std::int64_t number);

// 1.0 and 2.2: one line a node, one line an element.
void read_gmsh_1_nodes(MeshCursor& cursor, FoundSolid& found);
void read_gmsh_1_elements(MeshCursor& cursor, FoundSolid& found);
void read_gmsh_2_nodes(MeshCursor& cursor, Encoding encoding, FoundSolid& found);
void read_gmsh_2_elements(MeshCursor& cursor, Encoding encoding, FoundSolid& found);

/// 4.1: the physical group of every volume that has one.
using GmshGroups = std::map<std::int64_t, std::int64_t>;
void read_gmsh_4_entities(MeshCursor& cursor, Encoding encoding, GmshGroups& groups);
void read_gmsh_4_nodes(MeshCursor& cursor, Encoding encoding, FoundSolid& found);
void read_gmsh_4_elements(MeshCursor& cursor, Encoding encoding, const GmshGroups& groups, FoundSolid& found);

}  // namespace turgor::io

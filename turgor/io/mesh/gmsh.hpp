// Shared by the readers of Gmsh's versions. Each reads from after the line that opens a section to the line
// that closes it. Internal to io/.
#pragma once

#include <map>

#include "turgor/io/mesh/solid_formats.hpp"

namespace turgor::io {

/// Reads the type of an element. Fails for types that are unknown, or that Turgor does not read.
ElementType read_gmsh_type(FileCursor& cursor);

// Versions 1.0 and 2.2: one line per node, one line per element.
void read_gmsh_1_nodes(FileCursor& cursor, FoundSolid& found);
void read_gmsh_1_elements(FileCursor& cursor, FoundSolid& found);
void read_gmsh_2_nodes(FileCursor& cursor, Encoding encoding, FoundSolid& found);
void read_gmsh_2_elements(FileCursor& cursor, Encoding encoding, FoundSolid& found);

/// Version 4.1: physical group by volume, for volumes that have one.
using GmshGroups = std::map<std::int64_t, std::int64_t>;
void read_gmsh_4_entities(FileCursor& cursor, Encoding encoding, GmshGroups& groups);
void read_gmsh_4_nodes(FileCursor& cursor, Encoding encoding, FoundSolid& found);
void read_gmsh_4_elements(FileCursor& cursor, Encoding encoding, const GmshGroups& groups, FoundSolid& found);

}  // namespace turgor::io

// Blocks for tests of the lattice.
#pragma once

#include "turgor/models/lattice/block_body.hpp"

// Blocks for tests of the lattice.
#pragma once

#include "turgor/models/lattice/build/block_body.hpp"

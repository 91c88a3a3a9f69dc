// Cloth: a sheet or a mass-spring mesh with wind, contact and self-collision. Each step solves backward Euler
// or BDF2. The linear system is solved by Jacobi sweeps with 3×3 diagonal blocks [Kang 2004], accelerated by
// Chebyshev weights, or by conjugate gradients. Equations, and the differences from the paper:
// docs/models/cloth.md.
//
//   build/build.hpp    mesh checks, springs or sheet, masses, numbering
//   step.hpp           one step: wind, forces, solution, contacts, motion, CCD
//   hold.hpp           held vertices
//   measure.hpp        energy, momentum, hold forces, distances of layers
#pragma once

#include "turgor/models/cloth/build/build.hpp"
#include "turgor/models/cloth/hold.hpp"
#include "turgor/models/cloth/measure.hpp"
#include "turgor/models/cloth/model/state.hpp"
#include "turgor/models/cloth/step.hpp"

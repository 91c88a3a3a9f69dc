// The one number type of the simulation and the macro that marks functions a GPU backend may call as well.
#pragma once

#ifdef __CUDACC__
#define TURGOR_HD __host__ __device__
#else
#define TURGOR_HD
#endif

namespace turgor {

using Real = float;

}  // namespace turgor

// The one number type of the simulation, the macro that marks functions a GPU backend may call as well, the
// one that promises the compiler that the iterations of the loop behind it touch different numbers, and the
// one that asks it to write them out one after the other.
#pragma once

#ifdef __CUDACC__
#define TURGOR_HD __host__ __device__
#else
#define TURGOR_HD
#endif

#ifdef __CUDACC__
#define TURGOR_LANES
#elif defined(__clang__)
#define TURGOR_LANES _Pragma("clang loop vectorize(assume_safety)")
#else
#define TURGOR_LANES _Pragma("GCC ivdep")
#endif

#ifdef __CUDACC__
#define TURGOR_UNROLL _Pragma("unroll")
#else
#define TURGOR_UNROLL _Pragma("GCC unroll 27")
#endif

namespace turgor {

using Real = float;

}  // namespace turgor

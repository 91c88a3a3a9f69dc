// Number type of the simulation (Real) and three macros. TURGOR_HD marks functions that a GPU may call as
// well. TURGOR_LANES promises that the iterations of the next loop are independent. TURGOR_UNROLL unrolls the
// next loop.
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

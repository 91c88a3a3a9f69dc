// The tasks of turgor-read.
#pragma once

#include <cstddef>

namespace turgor {

/// Walks through the whole content of an HDF5 file. True if HDF5 can read it, and each dataset needs no more
/// memory than its values and one chunk. Throws std::bad_alloc if HDF5 got no memory.
bool walk_through_hdf5(const char* path);

/// Decodes the slices first, first + step, … of the DecodeJob in shared memory. False if that memory is not
/// such a job.
bool decode_dicom(int shared_file, std::size_t first, std::size_t step);

}  // namespace turgor

// Agreement between the library and the program turgor-read:
//   turgor-read PROTOCOL MEMORY hdf5 FILE           walks through an HDF5 file
//   turgor-read PROTOCOL MEMORY dicom FIRST STEP    decodes every STEP-th slice of dicom/decode_job.hpp
// MEMORY is what it may add to its address space [bytes]. Its exit status is a ReaderEnd.
#pragma once

namespace turgor::io {

constexpr int kReaderProtocol = 1;

enum ReaderEnd : int { kSound = 0, kUnsound = 1, kWrongUse = 2, kOtherProtocol = 253, kNoMemory = 254 };

}  // namespace turgor::io

// The program turgor-read, which opens files with libraries that crash, hang or take unlimited memory on
// damaged ones (HDF5, GDCM's codecs). It is another program, because a fork of a process with several threads
// may wait forever for a lock of such a library.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/io/files/child.hpp"

namespace turgor::io {

/// Path of turgor-read: $TURGOR_READ; else near the file that contains this code (the program, the C library
/// or the Python module), if its owner is the same or root; else in a folder of the PATH. The error says
/// where it was expected.
Result<std::filesystem::path> find_reader();

/// Starts turgor-read (reader_protocol.hpp), found at `program`. `limits.memory` is what it may add to its
/// own address space.
Child start_reader(const std::filesystem::path& program, const std::vector<std::string>& work,
                   const ChildLimits& limits, int shared = -1);

/// The end of turgor-read with its exit status interpreted. Error: the status is no verdict on the file, as
/// of a program of another version or without its libraries.
Result<ChildEnd> end_of_reader(ChildEnd end);

}  // namespace turgor::io

// Check of an HDF5 file before it is opened: turgor-read walks through it, with limits. HDF5 loops forever,
// exhausts memory or crashes on some damaged files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "turgor/core/result.hpp"
#include "turgor/io/files/child.hpp"

namespace turgor::io {

/// Limits of the check of a file of that size. Times grow with the size: a long recording has hundreds of
/// thousands of datasets.
ChildLimits hdf5_check_limits(std::uintmax_t file_size);

/// Damage of a file: empty, "damaged or cut short", or that with the reason why turgor-read was stopped.
/// Error: the file could not be checked, so that it may be sound; names the file.
Result<std::string> find_hdf5_damage(const std::filesystem::path& path, const ChildLimits& limits);

}  // namespace turgor::io

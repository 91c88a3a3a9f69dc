// Files that a package ships beside the program, such as fonts, for systems that do not install them.
#pragma once

#include <filesystem>
#include <initializer_list>

namespace turgor {

/// First existing file of `system`, else `name` in the folder that the environment variable TURGOR_SHARE
/// names, else ../share/turgor/`name` relative to the running program, if its owner is the program's owner or
/// root. Empty if no such file exists.
std::filesystem::path shipped_file(const std::filesystem::path& name,
                                   std::initializer_list<std::filesystem::path> system);

namespace io {
/// The same relative to another program.
std::filesystem::path file_shipped_with(const std::filesystem::path& program,
                                        const std::filesystem::path& name);
}  // namespace io

}  // namespace turgor

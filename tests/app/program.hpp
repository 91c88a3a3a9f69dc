// Runs the built program in a shell: takes a command line, returns the exit code and the output.
#pragma once

#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "tests/folders.hpp"
#include "tests/shell.hpp"

namespace turgor::test {

namespace fs = std::filesystem;

/// Runs a shell command in a folder. This test program has its own cache of Green's functions.
inline Ended run_shell(const std::string& command, const fs::path& folder) {
  static const fs::path cache = fresh_folder();
  return run_command("export XDG_CACHE_HOME='" + cache.string() + "' && " + command, folder);
}

/// Runs the program with arguments as a shell reads them. `before` is a shell command that runs first, such
/// as "ulimit -f 8".
inline Ended run_program(const std::string& arguments, const fs::path& folder,
                         const std::string& before = "true") {
  return run_shell(before + " && '" TURGOR_PROGRAM "' " + arguments, folder);
}

/// True where a line of the output is an error of the program. A slow machine prints progress before it.
inline bool has_error_line(const std::string& printed) {
  return ("\n" + printed).find("\nturgor: ") != std::string::npos;
}

inline nlohmann::json read_json(const fs::path& file) { return nlohmann::json::parse(std::ifstream(file)); }
/// The report of a run.
inline nlohmann::json report_in(const fs::path& folder) { return read_json(folder / "report.json"); }

/// A scene that runs in about a second: a small phantom, small pictures.
inline std::string small_scene(const std::string& body = "", const std::string& rest = "") {
  return "[world]\nduration = 0.2\nframe_rate = 50\n[body.torso]\nmodel = \"lattice\"\n"
         "ct = { phantom = \"torso\", size = [64, 48, 40], spacing_mm = [6.5, 6.5, 6.5] }\nblock = 2\n"
         "fixed = [\"bone\", \"ends\"]\ntissue = { law = \"springs\", volume = 2 }\n" +
         body +
         "\n[incision.midline]\nbody = \"torso\"\nfrom_fraction = [0.5, 0.0, 0.7]\nto_fraction = [0.5, 0.0, "
         "0.3]\n"
         "depth = 0.02\nstart = 0.02\nduration = 0.05\n"
         "[output]\nsnapshots = { every = 0.1, size = [200, 160] }\ndeformed_ct = \"deformed.nii.gz\"\n" +
         rest;
}

}  // namespace turgor::test

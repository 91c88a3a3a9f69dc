// Commands of the program `turgor` and of the programs beside it (other_programs.hpp). Each
// add_<name>_command declares one subcommand with its options. The callback does the work of the command and
// throws Failure with a sentence on errors.
#pragma once

#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "app/print.hpp"
#include "turgor/core/result.hpp"

namespace turgor {

/// Options that every command shares.
struct Global {
  int threads = 0;  // 0 = one per core
};

constexpr int kNotFinite = 3;  // exit code: a simulation ended early because of non-finite numbers

/// Prints a remark on standard error; the command continues.
inline void note(const std::string& sentence) { print_message("turgor: note", sentence); }

/// Thrown by the callback of a command; main prints the message after "turgor: " and exits with the code.
struct Failure {
  int exit_code = 2;
  std::string message;
};

/// Returns the value, or throws Failure with the error message after the prefix `where`.
template <class T>
T required(Result<T> result, const std::string& where = {}) {
  if (!result) throw Failure{2, where + result.error().message};
  return std::move(*result);
}

/// True if an existing output file is an input, or lies in an input folder.
inline bool replaces_input(const std::filesystem::path& output, const std::filesystem::path& input) {
  namespace fs = std::filesystem;
  std::error_code failed;
  if (input.empty() || !fs::exists(output, failed)) return false;
  if (fs::equivalent(output, input, failed)) return true;
  if (!fs::is_directory(input, failed)) return false;
  const fs::path inside = fs::canonical(output, failed).lexically_relative(fs::canonical(input, failed));
  return !inside.empty() && *inside.begin() != "..";
}

/// Validator of an option: a finite number from `low` to `high`.
inline CLI::Validator number_within(double low, double high, const std::string& unit) {
  return CLI::Validator(
      [low, high, unit](const std::string& text) {
        double value = 0;
        if (CLI::detail::lexical_cast(text, value) && value >= low && value <= high) return std::string();
        std::ostringstream expected;
        expected << "expected a number from " << low << " to " << high << " [" << unit << "], found " << text;
        return expected.str();
      },
      unit);
}

/// Validator of an option: one of these names.
inline CLI::Validator one_of(const std::vector<std::string>& names) {
  return CLI::Validator(
      [names](const std::string& text) {
        std::string expected;
        for (const std::string& name : names) {
          if (name == text) return std::string();
          expected += (expected.empty() ? "" : name == names.back() ? " or " : ", ") + name;
        }
        return "expected " + expected + ", found " + text;
      },
      "");
}

/// Adds the option --set to a command that reads a scene; `overrides` must outlive the parsing.
inline void add_set_option(CLI::App& command, std::vector<std::string>& overrides) {
  command
      .add_option("--set", overrides,
                  "key=value: overrides a key of the scene, key= removes it; may be repeated")
      ->type_size(1)
      ->allow_extra_args(false);
}

// `global` must outlive the parsing; callbacks read it.
void add_info_command(CLI::App& program, Global& global);
void add_import_command(CLI::App& program, Global& global);
void add_phantom_command(CLI::App& program, Global& global);
void add_mesh_command(CLI::App& program, Global& global);
void add_run_command(CLI::App& program, Global& global);
void add_bench_command(CLI::App& program, Global& global);
void add_validate_command(CLI::App& program, Global& global);
void add_calibrate_command(CLI::App& program, Global& global);
void add_identify_command(CLI::App& program, Global& global);
void add_plan_excision_command(CLI::App& program, Global& global);
void add_cache_command(CLI::App& program);
void add_devices_command(CLI::App& program);
void add_tissues_command(CLI::App& program);
void add_replay_command(CLI::App& program, Global& global);

}  // namespace turgor

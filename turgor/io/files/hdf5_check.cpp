#include "turgor/io/files/hdf5_check.hpp"

#include <cerrno>
#include <csignal>

#include <fmt/format.h>

#include "turgor/io/files/reader_program.hpp"

namespace turgor::io {

namespace {

Error no_verdict(const std::filesystem::path& path, const std::string& reason) {
  return {fmt::format("{}: cannot be checked: {}", path.string(), reason)};
}

}  // namespace

ChildLimits hdf5_check_limits(std::uintmax_t file_size) {
  // a file of nothing but small datasets takes 0.05 s a megabyte on two busy cores
  const double seconds = 10 + 0.25 * double(file_size) * 1e-6;
  return {.seconds = 110 + seconds, .processor_seconds = seconds, .memory = std::size_t{256} << 20};
}

Result<std::string> find_hdf5_damage(const std::filesystem::path& path, const ChildLimits& limits) {
  const Result<std::filesystem::path> program = find_reader();
  if (!program) return no_verdict(path, program.error().message);
  const Child child = start_reader(*program, {"hdf5", path.string()}, limits);
  const Result<ChildEnd> end = end_of_reader(wait_for({&child, 1}, limits)[0]);
  if (!end) return no_verdict(path, end.error().message);
  // without a check if the system has no process to give
  const bool is_refused = end->kind == ChildEnd::Kind::kNotStarted;
  if (is_refused && (end->number == EAGAIN || end->number == ENOMEM || end->number == ECHILD))
    return std::string();
  const bool is_too_long = end->kind == ChildEnd::Kind::kTooLong ||
                           (end->kind == ChildEnd::Kind::kCrashed && end->number == SIGXCPU);
  if (is_refused || is_too_long) return no_verdict(path, describe(*end, limits));
  const std::string damage = "damaged or cut short";
  if (end->kind == ChildEnd::Kind::kOutOfMemory)
    return fmt::format("{}, or too large to be checked: {}", damage, describe(*end, limits));
  return *end ? std::string() : damage;
}

}  // namespace turgor::io

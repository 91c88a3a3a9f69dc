#include "turgor/io/files/reader_program.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "turgor/io/files/reader_protocol.hpp"

namespace turgor::io {

namespace {

namespace fs = std::filesystem;

constexpr const char* kName = "turgor-read";
// Relative to the folder of the program, library or module: installed trees, then build trees.
constexpr const char* kFolders[] = {
    ".", "../libexec/turgor", "../../libexec/turgor", "../bin", "../../bin", "..", "../.."};

/// File that contains this code, by its mapping; unlike dladdr's it is an absolute path for programs too.
fs::path file_of_this_code() {
  const auto own = reinterpret_cast<std::uintptr_t>(&find_reader);
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    unsigned long begin = 0, end = 0;
    const std::size_t path = line.find('/');
    if (std::sscanf(line.c_str(), "%lx-%lx", &begin, &end) != 2 || own < begin || own >= end) continue;
    return path == line.npos ? fs::path() : fs::path(line.substr(path));
  }
  return {};
}

bool is_program(const fs::path& file) {
  struct stat status {};
  return stat(file.c_str(), &status) == 0 && S_ISREG(status.st_mode) && access(file.c_str(), X_OK) == 0;
}

/// True for a file of root or of this code's owner: others may write into a folder above, such as /tmp.
bool is_trusted(const fs::path& file, const fs::path& code) {
  struct stat status {
  }, own{};
  return stat(file.c_str(), &status) == 0 &&
         (status.st_uid == 0 || (stat(code.c_str(), &own) == 0 && status.st_uid == own.st_uid));
}

fs::path near_this_code() {
  static const fs::path code = file_of_this_code();
  if (code.empty()) return {};
  for (const char* folder : kFolders)
    if (const fs::path file = (code.parent_path() / folder / kName).lexically_normal();
        is_program(file) && is_trusted(file, code))
      return file;
  return {};
}

fs::path on_the_path() {
  const char* folders = std::getenv("PATH");
  for (std::string rest = folders ? folders : ""; !rest.empty();) {
    const std::size_t end = std::min(rest.find(':'), rest.size());
    const fs::path folder = rest.substr(0, end);
    if (folder.is_absolute() && is_program(folder / kName)) return folder / kName;
    rest.erase(0, end + 1);
  }
  return {};
}

}  // namespace

Result<fs::path> find_reader() {
  if (const char* given = std::getenv("TURGOR_READ"); given && *given) {
    std::error_code failed;
    const fs::path file = fs::absolute(given, failed);
    if (!failed && is_program(file)) return file;
    return Error{fmt::format("TURGOR_READ: expected the path of the program {}, found \"{}\"", kName, given)};
  }
  for (const fs::path& file : {near_this_code(), on_the_path()})
    if (!file.empty()) return file;
  return Error{
      fmt::format("the program {0} was not found, neither near {1} nor on the PATH; it is installed with "
                  "turgor, and the variable TURGOR_READ may hold its path",
                  kName, file_of_this_code().string())};
}

Child start_reader(const fs::path& program, const std::vector<std::string>& work, const ChildLimits& limits,
                   int shared) {
  std::vector<std::string> arguments{program.string(), std::to_string(kReaderProtocol),
                                     std::to_string(limits.memory)};
  arguments.insert(arguments.end(), work.begin(), work.end());
  ChildLimits own = limits;
  own.memory = RLIM_INFINITY;  // it limits itself, relative to the size with which it starts
  return start_program(arguments, ".", "/dev/null", own, shared);
}

Result<ChildEnd> end_of_reader(ChildEnd end) {
  if (end.kind != ChildEnd::Kind::kExited) return end;
  if (end.number == kNoMemory) end.kind = ChildEnd::Kind::kOutOfMemory;
  if (end.number == kSound || end.number == kUnsound || end.number == kNoMemory) return end;
  const Result<fs::path> program = find_reader();
  const bool is_other = end.number == kOtherProtocol || end.number == kWrongUse;
  return Error{
      (program ? program->string() : kName) +
      (is_other ? " is of another version of turgor" : fmt::format(" ended with status {}", end.number))};
}

}  // namespace turgor::io

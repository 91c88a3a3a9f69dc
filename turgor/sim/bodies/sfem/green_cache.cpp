#include "turgor/sim/bodies/sfem/green_cache.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>

#include <fmt/format.h>

#include "turgor/core/assert.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/io/files/hdf5_file.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

constexpr const char* kGreenFormat = "turgor Green's functions 3";
constexpr std::size_t kMostChecks = 1 << 10;

template <class T>
Status read_into(const Hdf5File& file, const char* name, std::size_t count, std::vector<T>& values) {
  Result<std::vector<T>> read = file.read<T>(name, count);
  if (!read) return read.error();
  values = std::move(*read);
  return Done{};
}

/// Values as stored; sfem::check_green verifies them. `unchecked`: as in Hdf5File::open.
Result<sfem::Green> read_values(const fs::path& path, const sfem::Model& model, bool& unchecked) {
  // check the format
  const Result<Hdf5File> file = Hdf5File::open(path, &unchecked);
  if (!file) return file.error();
  const Result<std::string> format = file->read_text("/format");
  if (!format || *format != kGreenFormat)
    return Error{fmt::format("{}: expected \"{}\", found {}", path.string(), kGreenFormat,
                             format ? "\"" + *format + "\"" : std::string("another HDF5 file"))};
  // check that the file belongs to this body
  std::vector<std::uint64_t> content, sum;
  if (const Status s = read_into(*file, "/content_hash", 1, content); !s) return s.error();
  if (content[0] != sfem::content_hash(model))
    return Error{fmt::format("{}: it is of another body: expected content {}, found {}", path.string(),
                             hash_text(sfem::content_hash(model)), hash_text(content[0]))};
  // read the values in the model's precision
  sfem::Green green;
  green.nodes = model.green.nodes, green.surface_count = model.green.surface_count;
  green.slot = model.green.slot;
  const std::size_t count = 9 * green.nodes.size() * green.nodes.size();
  const Status read = model.params.precision == sfem::Precision::kSingle
                          ? read_into(*file, "/values", count, green.single_values)
                          : read_into(*file, "/values", count, green.double_values);
  if (!read) return read.error();
  // read the columns for verification
  const Result<std::size_t> checks = file->count("/check/vertices", kMostChecks);
  if (!checks) return checks.error();
  if (const Status s = read_into(*file, "/check/vertices", *checks, green.check.vertices); !s)
    return s.error();
  const std::size_t check_values = 9 * *checks * model.vertex.size();
  if (const Status s = read_into(*file, "/check/values", check_values, green.check.values); !s)
    return s.error();
  // read the checksum
  if (const Status s = read_into(*file, "/checksum", 1, sum); !s) return s.error();
  green.checksum = sum[0];
  return green;
}

Status write_values(Unfinished& partial, const sfem::Model& model, const std::string& what_for) {
  Result<Hdf5File> file = Hdf5File::create(partial.path());
  if (!file) return file.error();
  partial.hold();
  const sfem::Green& green = model.green;
  const std::size_t columns = 3 * green.nodes.size();
  TURGOR_CHECK(green.single_values.size() + green.double_values.size() == columns * columns,
               "every column of a written store is computed");
  Status status = file->write_text("/format", kGreenFormat);
  if (status) status = file->write_text("/what_for", what_for);
  const auto write = [&]<class T>(const char* name, const std::vector<T>& values, std::size_t width) {
    // Hardly smaller when compressed, and much slower.
    if (status) status = file->write(name, std::span<const T>(values), width, Hdf5Packing::kPlain);
  };
  write("/content_hash", std::vector<std::uint64_t>{sfem::content_hash(model)}, 1);
  if (model.params.precision == sfem::Precision::kSingle)
    write("/values", green.single_values, columns);
  else
    write("/values", green.double_values, columns);
  write("/check/vertices", green.check.vertices, 1);
  write("/check/values", green.check.values, 1);
  write("/checksum", std::vector<std::uint64_t>{green.checksum}, 1);
  return status ? file->close() : status;
}

}  // namespace

fs::path green_cache_file(const fs::path& folder, std::uint64_t content_hash) {
  std::error_code ignored;
  const fs::path where = folder.empty() ? user_cache_folder() : fs::absolute(folder, ignored);
  return where.empty() ? fs::path() : where / fmt::format("green-{}.h5", hash_text(content_hash));
}

CachedGreen read_green(const fs::path& path, sfem::Model& model) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) return {};
  bool unchecked = false;
  Result<sfem::Green> green = read_values(path, model, unchecked);
  if (unchecked) return {false, green.error().message + "; computed, the file is kept", true};
  if (!green) return {false, green.error().message + "; recomputed"};
  std::swap(model.green, *green);
  const Status checked = sfem::check_green(model);
  if (checked) {
    fs::last_write_time(path, fs::file_time_type::clock::now(), ignored);  // marks the file as used
    return {true, ""};
  }
  std::swap(model.green, *green);
  return {false, fmt::format("{}: {}; recomputed", path.string(), checked.error().message)};
}

Status write_green(const fs::path& path, const sfem::Model& model, const std::string& what_for) {
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  if (const Status goal = check_file_goal(path); !goal) return goal;
  Unfinished partial(path);
  if (const Status status = write_values(partial, model, what_for); !status) return status;
  return partial.keep([&]() -> Result<fs::path> {
    if (rename(partial.path().c_str(), path.c_str()) == 0) return path;
    return Error{fmt::format("{}: cannot rename the file: {}", path.string(), std::strerror(errno))};
  });
}

}  // namespace turgor

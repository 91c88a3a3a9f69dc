// Arrays and texts by name in an HDF5 file: compressed, with checksums, readable from Python, MATLAB and
// h5dump. Every reader states the size that it expects. A damaged file therefore gives an error and never an
// allocation of the size that it claims.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"

namespace turgor {

/// Compression of values; both kinds have checksums.
enum class Hdf5Packing : std::uint8_t { kCompressed, kPlain };

class Hdf5File {
 public:
  static Result<Hdf5File> create(const std::filesystem::path& path);
  /// Error: the file does not exist, is not HDF5, is damaged, or cannot be checked. `unchecked` becomes true
  /// if it could not be checked, so that the file may be sound.
  static Result<Hdf5File> open(const std::filesystem::path& path, bool* unchecked = nullptr);
  /// Opens a file that was flushed or closed, to write more into it. Error: as open.
  static Result<Hdf5File> open_to_write(const std::filesystem::path& path);
  Hdf5File(Hdf5File&& other) noexcept;
  Hdf5File& operator=(Hdf5File&&) = delete;
  ~Hdf5File();

  /// Writes rows of `columns` values each as a new dataset; creates the groups in its name. T: float, double,
  /// std::uint8_t, std::int32_t, std::int64_t, std::uint64_t.
  template <class T>
  Status write(const std::string& name, std::span<const T> values, std::size_t columns = 1,
               Hdf5Packing packing = Hdf5Packing::kCompressed);
  /// Appends rows to a growing dataset, which the first call creates. With one column it has a single axis.
  template <class T>
  Status append(const std::string& name, std::span<const T> values, std::size_t columns = 1);
  Status write_text(const std::string& name, const std::string& text);
  /// Creates a group and its parent groups.
  Status make_group(const std::string& name);
  /// Attribute of a written dataset or of a group, such as its unit.
  Status write_attribute(const std::string& name, const std::string& attribute, const std::string& text);
  /// The same as ASCII of exact length, without a terminating zero.
  Status write_ascii_attribute(const std::string& name, const std::string& attribute,
                               const std::string& text);
  /// One number, or an array of numbers.
  Status write_attribute(const std::string& name, const std::string& attribute,
                         std::span<const std::int64_t> numbers);
  /// Data written so far survives a crash of the program.
  Status flush();
  /// Closes a written file; it cannot be used afterwards.
  Status close();

  const std::filesystem::path& path() const { return path_; }
  bool has(const std::string& name) const;
  /// Reads a dataset of exactly `count` values. Error: missing, of another size or type, or damaged.
  template <class T>
  Result<std::vector<T>> read(const std::string& name, std::size_t count) const;
  /// Number of values of a dataset. Error: missing, or more than `most`.
  Result<std::size_t> count(const std::string& name, std::size_t most) const;
  Result<std::string> read_text(const std::string& name) const;
  /// Empty if the dataset or the attribute does not exist.
  std::string read_attribute(const std::string& name, const std::string& attribute) const;
  /// Integer attribute.
  std::vector<std::int64_t> read_numbers(const std::string& name, const std::string& attribute) const;
  /// Names of all datasets, ascending.
  std::vector<std::string> datasets() const;

 private:
  Hdf5File(std::filesystem::path path, std::int64_t id) : path_(std::move(path)), id_(id) {}
  Error error(const std::string& name, const std::string& what) const;
  Status write_attribute(const std::string& name, const std::string& attribute, std::int64_t type,
                         std::int64_t space, const void* value);

  std::filesystem::path path_;
  std::int64_t id_ = -1;
};

}  // namespace turgor

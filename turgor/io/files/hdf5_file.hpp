// Arrays and texts by name in an HDF5 file: compressed, with checksums, readable from Python, MATLAB and
// h5dump. Every reader says how much it expects, so that a damaged file is an error and never an allocation
// of what it claims to hold.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"

namespace turgor {

/// Whether values are compressed; both ways they have checksums.
enum class Hdf5Packing : std::uint8_t { kCompressed, kPlain };

class Hdf5File {
 public:
  static Result<Hdf5File> create(const std::filesystem::path& path);
  /// Error: not there, not HDF5, or cut short.
  static Result<Hdf5File> open(const std::filesystem::path& path);
  Hdf5File(Hdf5File&& other) noexcept;
  Hdf5File& operator=(Hdf5File&&) = delete;
  ~Hdf5File();

  /// Writes rows of `columns` values each as a new dataset; groups in the name are made. T: float, double,
  /// std::uint8_t, std::int32_t, std::int64_t, std::uint64_t.
  template <class T>
  Status write(const std::string& name, std::span<const T> values, std::size_t columns = 1,
               Hdf5Packing packing = Hdf5Packing::kCompressed);
  /// Adds rows to a dataset that grows, made at the first time; of one column it has one axis alone.
  template <class T>
  Status append(const std::string& name, std::span<const T> values, std::size_t columns = 1);
  Status write_text(const std::string& name, const std::string& text);
  /// A group, and those that it is in.
  Status make_group(const std::string& name);
  /// What a dataset that was written, or a group, says about itself, as its unit.
  Status write_attribute(const std::string& name, const std::string& attribute, const std::string& text);
  /// The same of ASCII and as long as it is, without a zero behind it.
  Status write_ascii_attribute(const std::string& name, const std::string& attribute,
                               const std::string& text);
  /// One number, or a row of them.
  Status write_attribute(const std::string& name, const std::string& attribute,
                         std::span<const std::int64_t> numbers);
  /// Everything written so far survives a crash of the program.
  Status flush();
  /// Ends a file that was written; nothing else may be done with it then.
  Status close();

  const std::filesystem::path& path() const { return path_; }
  bool has(const std::string& name) const;
  /// Reads a dataset of exactly `count` values. Error: missing, of another size or type, or damaged.
  template <class T>
  Result<std::vector<T>> read(const std::string& name, std::size_t count) const;
  /// The number of values of a dataset. Error: missing, or more than `most`.
  Result<std::size_t> count(const std::string& name, std::size_t most) const;
  Result<std::string> read_text(const std::string& name) const;
  /// Empty when there is no such dataset, or none of this attribute.
  std::string read_attribute(const std::string& name, const std::string& attribute) const;
  /// The same of whole numbers.
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

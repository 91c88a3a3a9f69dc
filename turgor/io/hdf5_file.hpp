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
  /// std::uint8_t, std::int32_t, std::uint64_t.
  template <class T>
  Status write(const std::string& name, std::span<const T> values, std::size_t columns = 1,
               Hdf5Packing packing = Hdf5Packing::kCompressed);
  Status write_text(const std::string& name, const std::string& text);
  /// What a dataset that was written says about itself, as its unit.
  Status write_attribute(const std::string& name, const std::string& attribute, const std::string& text);
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
  /// Names of all datasets, ascending.
  std::vector<std::string> datasets() const;

 private:
  Hdf5File(std::filesystem::path path, std::int64_t id) : path_(std::move(path)), id_(id) {}
  Error error(const std::string& name, const std::string& what) const;

  std::filesystem::path path_;
  std::int64_t id_ = -1;
};

}  // namespace turgor

// Recordings with the dataset names of an earlier format, or with other numbers.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "turgor/io/files/hdf5_file.hpp"

namespace turgor::test {

/// Copies one dataset of numbers if its values are of type T.
template <class T>
bool copy_numbers(const Hdf5File& from, Hdf5File& to, const std::string& path, const std::string& new_path) {
  const Result<std::size_t> count = from.count(path, std::size_t(1) << 24);
  if (!count) return false;
  const Result<std::vector<T>> values = from.read<T>(path, *count);
  return values && bool(to.write<T>(new_path, *values));
}

/// Copies one dataset, whatever its values are.
inline bool copy_dataset(const Hdf5File& from, Hdf5File& to, const std::string& path,
                         const std::string& new_path) {
  if (const Result<std::string> text = from.read_text(path); text)
    return bool(to.write_text(new_path, *text));
  return copy_numbers<float>(from, to, path, new_path) || copy_numbers<double>(from, to, path, new_path) ||
         copy_numbers<std::uint8_t>(from, to, path, new_path) ||
         copy_numbers<std::int32_t>(from, to, path, new_path) ||
         copy_numbers<std::uint64_t>(from, to, path, new_path);
}

/// Copies one dataset of numbers with a changed value. False: it holds another type.
template <class T>
bool copy_with_number(const Hdf5File& from, Hdf5File& to, const std::string& path, std::size_t count,
                      std::size_t index, double value) {
  Result<std::vector<T>> values = from.read<T>(path, count);
  if (!values) return false;
  (*values)[index] = T(value);
  return bool(to.write<T>(path, *values));
}

/// Writes a copy of an HDF5 file in which one dataset of numbers has a changed value.
inline void write_with_number(const std::filesystem::path& from, const std::filesystem::path& to,
                              const std::string& changed, std::size_t index, double value) {
  const Result<Hdf5File> source = Hdf5File::open(from);
  Result<Hdf5File> target = Hdf5File::create(to);
  ASSERT_TRUE(source && target);
  for (const std::string& path : source->datasets()) {
    if (path != changed) {
      EXPECT_TRUE(copy_dataset(*source, *target, path, path)) << path;
      continue;
    }
    const Result<std::size_t> count = source->count(path, std::size_t(1) << 24);
    ASSERT_TRUE(count && index < *count) << path;
    EXPECT_TRUE(copy_with_number<double>(*source, *target, path, *count, index, value) ||
                copy_with_number<float>(*source, *target, path, *count, index, value) ||
                copy_with_number<std::int32_t>(*source, *target, path, *count, index, value));
  }
  EXPECT_TRUE(target->close());
}

/// Writes a copy of an HDF5 file with other names of datasets (last component of the path) and another
/// /format. Returns the number of different names that were replaced.
inline int write_with_names(const std::filesystem::path& from, const std::filesystem::path& to,
                            const std::map<std::string, std::string>& names, const std::string& format) {
  const Result<Hdf5File> source = Hdf5File::open(from);
  Result<Hdf5File> target = Hdf5File::create(to);
  EXPECT_TRUE(source && target);
  std::map<std::string, int> replaced;
  for (const std::string& path : source->datasets()) {
    const std::size_t name_begin = path.rfind('/') + 1;
    const auto name = names.find(path.substr(name_begin));
    if (name != names.end()) replaced[name->first]++;
    const std::string new_path = name == names.end() ? path : path.substr(0, name_begin) + name->second;
    const bool copied = path == "/format" ? bool(target->write_text(new_path, format))
                                          : copy_dataset(*source, *target, path, new_path);
    EXPECT_TRUE(copied) << path;
  }
  EXPECT_TRUE(target->close());
  return int(replaced.size());
}

}  // namespace turgor::test

// Sequential writers and readers of the arrays in a group, which stop at the first error. Used by
// recording*.cpp.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "turgor/io/files/hdf5_file.hpp"
#include "turgor/sim/recording/renamed_datasets.hpp"
#include "turgor/sim/snapshot.hpp"

namespace turgor {

/// Target of a snapshot; every model has a write_state(out, body, id).
struct SnapshotOut {
  Hdf5File& file;
  std::string group;  // without trailing slash
  const WorldSnapshot& snapshot;
};
/// Source of a snapshot, for the world and for its drawing; every model has a read_state(in, body, id).
struct SnapshotIn {
  const Hdf5File& file;
  std::string path;   // of the file, for errors
  std::string group;  // without trailing slash
  const Exec& exec;
  const World& world;
  WorldSnapshot& snapshot;
};

/// Coordinates of points, three per point.
template <class T>
std::vector<T> flat(const std::vector<Vec<T>>& points) {
  std::vector<T> values;
  values.reserve(3 * points.size());
  for (const Vec<T> p : points) values.insert(values.end(), {p.x, p.y, p.z});
  return values;
}

/// Writes arrays until the first error.
class Writing {
 public:
  Writing(Hdf5File& file, std::string group) : file_(file), group_(std::move(group)) {}

  /// `unit` becomes an attribute; a comma-separated list for columns with different units.
  template <class T>
  Writing& array(const std::string& name, const std::vector<T>& values, std::size_t columns = 1,
                 const std::string& unit = "") {
    if (status_) status_ = file_.write<T>(group_ + name, std::span<const T>(values), columns);
    if (status_ && !unit.empty()) status_ = file_.write_attribute(group_ + name, "unit", unit);
    return *this;
  }
  Writing& text(const std::string& name, const std::string& value) {
    if (status_) status_ = file_.write_text(group_ + name, value);
    return *this;
  }
  Status status() const { return status_; }

 private:
  Hdf5File& file_;
  std::string group_;
  Status status_ = Done{};
};

/// Reads arrays until the first error.
class Reading {
 public:
  Reading(const Hdf5File& file, std::string group) : file_(file), group_(std::move(group)) {}

  template <class T>
  std::vector<T> array(const std::string& name, std::size_t count) {
    if (!status_) return {};
    Result<std::vector<T>> values = file_.read<T>(stored_path(file_, group_ + name), count);
    if (!values) status_ = values.error();
    return values ? std::move(*values) : std::vector<T>();
  }
  std::size_t count(const std::string& name, std::size_t most) {
    if (!status_) return 0;
    const Result<std::size_t> found = file_.count(stored_path(file_, group_ + name), most);
    if (!found) status_ = found.error();
    return found ? *found : 0;
  }
  /// Reports invalid data; the first message is kept.
  void fail(const std::string& name, const std::string& what) {
    if (status_) status_ = Error{file_.path().string() + ": " + group_ + name + ": " + what};
  }
  const Status& status() const { return status_; }
  const std::string& group() const { return group_; }

 private:
  const Hdf5File& file_;
  std::string group_;
  Status status_ = Done{};
};

}  // namespace turgor

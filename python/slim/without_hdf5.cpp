// Replaces turgor/io/files/hdf5_file.cpp in the slim module: every file is refused with a message. Green's
// functions are then computed in every run; nothing else of a simulation needs HDF5.
#include <utility>

#include "turgor/io/files/hdf5_file.hpp"

namespace turgor {

namespace {

Error without(const std::filesystem::path& path) {
  return {path.string() +
          ": this build of turgor has no HDF5, which caches, recordings and haptic recordings need"};
}

}  // namespace

Result<Hdf5File> Hdf5File::create(const std::filesystem::path& path) { return without(path); }
Result<Hdf5File> Hdf5File::open(const std::filesystem::path& path, bool*) { return without(path); }

// never called, needed for linking
Hdf5File::Hdf5File(Hdf5File&& other) noexcept
    : path_(std::move(other.path_)), id_(std::exchange(other.id_, -1)) {}
Hdf5File::~Hdf5File() = default;
Error Hdf5File::error(const std::string&, const std::string&) const { return without(path_); }

template <class T>
Status Hdf5File::write(const std::string&, std::span<const T>, std::size_t, Hdf5Packing) {
  return without(path_);
}
template <class T>
Status Hdf5File::append(const std::string&, std::span<const T>, std::size_t) {
  return without(path_);
}
template <class T>
Result<std::vector<T>> Hdf5File::read(const std::string&, std::size_t) const {
  return without(path_);
}

#define TURGOR_WITHOUT(T)                                                                            \
  template Status Hdf5File::write(const std::string&, std::span<const T>, std::size_t, Hdf5Packing); \
  template Status Hdf5File::append(const std::string&, std::span<const T>, std::size_t);             \
  template Result<std::vector<T>> Hdf5File::read(const std::string&, std::size_t) const;
TURGOR_WITHOUT(float)
TURGOR_WITHOUT(double)
TURGOR_WITHOUT(std::uint8_t)
TURGOR_WITHOUT(std::int32_t)
TURGOR_WITHOUT(std::uint64_t)
#undef TURGOR_WITHOUT

Status Hdf5File::write_text(const std::string&, const std::string&) { return without(path_); }
Status Hdf5File::write_attribute(const std::string&, const std::string&, const std::string&) {
  return without(path_);
}
Status Hdf5File::flush() { return without(path_); }
Status Hdf5File::close() { return without(path_); }
bool Hdf5File::has(const std::string&) const { return false; }
Result<std::size_t> Hdf5File::count(const std::string&, std::size_t) const { return without(path_); }
Result<std::string> Hdf5File::read_text(const std::string&) const { return without(path_); }
std::string Hdf5File::read_attribute(const std::string&, const std::string&) const { return {}; }
std::vector<std::string> Hdf5File::datasets() const { return {}; }

}  // namespace turgor

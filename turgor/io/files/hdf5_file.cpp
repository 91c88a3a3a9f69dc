#include "turgor/io/files/hdf5_file.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <hdf5.h>

#include "turgor/core/assert.hpp"
#include "turgor/io/files/hdf5_check.hpp"
#include "turgor/io/files/input_file.hpp"

namespace turgor {

namespace {

/// HDF5 identifier with its close function.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() { give_back(); }
  /// Closing a dataset writes its last bytes; false if that fails.
  bool give_back() { return id_ < 0 || close_(std::exchange(id_, -1)) >= 0; }
  operator hid_t() const { return id_; }  // NOLINT(google-explicit-constructor): used where HDF5 wants an id
  bool valid() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

template <class T>
hid_t type_of();
template <>
hid_t type_of<float>() {
  return H5T_NATIVE_FLOAT;
}
template <>
hid_t type_of<double>() {
  return H5T_NATIVE_DOUBLE;
}
template <>
hid_t type_of<std::uint8_t>() {
  return H5T_NATIVE_UINT8;
}
template <>
hid_t type_of<std::int32_t>() {
  return H5T_NATIVE_INT32;
}
template <>
hid_t type_of<std::int64_t>() {
  return H5T_NATIVE_INT64;
}
template <>
hid_t type_of<std::uint64_t>() {
  return H5T_NATIVE_UINT64;
}

/// Turns off HDF5's error output on this thread. Errors are reported as messages of this program.
void silence() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

/// Turns off HDF5's error output and its exit handler. Files are closed before exit; for a file that could
/// not be closed (full disk), HDF5's handler would follow freed pointers.
void begin() {
  static const herr_t once = H5dont_atexit();
  (void)once;
  silence();
}

/// Chunks of about a megabyte with a checksum; compressed chunks are byte-shuffled first.
void pack(hid_t properties, hsize_t rows, hsize_t columns, std::size_t value_size, Hdf5Packing packing) {
  constexpr hsize_t kChunkBytes = 1 << 20;
  constexpr unsigned kLevel = 3;
  const hsize_t chunk_rows = std::clamp<hsize_t>(kChunkBytes / (columns * value_size), 1, rows);
  const hsize_t chunk[2] = {chunk_rows, columns};
  H5Pset_chunk(properties, 2, chunk);
  if (packing == Hdf5Packing::kCompressed) {
    H5Pset_shuffle(properties);
    H5Pset_deflate(properties, kLevel);
  }
  H5Pset_fletcher32(properties);
}

}  // namespace

Hdf5File::Hdf5File(Hdf5File&& other) noexcept
    : path_(std::move(other.path_)), id_(std::exchange(other.id_, -1)) {}

Hdf5File::~Hdf5File() {
  if (id_ >= 0) H5Fclose(id_);
}

Error Hdf5File::error(const std::string& name, const std::string& what) const {
  return {fmt::format("{}: {}: {}", path_.string(), name, what)};
}

Result<Hdf5File> Hdf5File::create(const std::filesystem::path& path) {
  begin();
  const hid_t id = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  if (id < 0) return Error{fmt::format("{}: cannot create the file", path.string())};
  return Hdf5File(path, id);
}

Result<Hdf5File> Hdf5File::open(const std::filesystem::path& path, bool* unchecked) {
  begin();
  std::error_code failed;
  const bool exists = std::filesystem::exists(path, failed);
  if (!exists && !failed)
    return Error{fmt::format("{}: expected an HDF5 file, found nothing", path.string())};
  const bool is_file = std::filesystem::is_regular_file(path, failed);
  if (Status input = io::check_input(path); (is_file || !exists) && !input) return input.error();
  if (!is_file || H5Fis_hdf5(path.c_str()) <= 0)
    return Error{fmt::format("{}: expected an HDF5 file, found something else", path.string())};
  const std::uintmax_t size = std::filesystem::file_size(path, failed);
  const Result<std::string> damage = io::find_hdf5_damage(path, io::hdf5_check_limits(failed ? 0 : size));
  if (unchecked) *unchecked = !damage;
  if (!damage) return damage.error();
  if (!damage->empty()) return Error{fmt::format("{}: the HDF5 file is {}", path.string(), *damage)};
  const hid_t id = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (id < 0) return Error{fmt::format("{}: the HDF5 file is damaged or cut short", path.string())};
  return Hdf5File(path, id);
}

Result<Hdf5File> Hdf5File::open_to_write(const std::filesystem::path& path) {
  if (const Result<Hdf5File> checked = open(path); !checked) return checked.error();
  const hid_t id = H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  if (id < 0) return Error{fmt::format("{}: the HDF5 file cannot be continued", path.string())};
  return Hdf5File(path, id);
}

template <class T>
Status Hdf5File::write(const std::string& name, std::span<const T> values, std::size_t columns,
                       Hdf5Packing packing) {
  TURGOR_ASSERT(values.size() % columns == 0, "every row of a dataset is whole");
  const hsize_t shape[2] = {values.size() / columns, columns};
  const Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose), layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(links, 1);
  constexpr std::size_t kSmall = 1024;  // bytes; smaller datasets are not chunked
  if (values.size_bytes() > kSmall) pack(layout, shape[0], shape[1], sizeof(T), packing);
  const Handle space(H5Screate_simple(2, shape, nullptr), H5Sclose);
  Handle set(H5Dcreate2(id_, name.c_str(), type_of<T>(), space, links, layout, H5P_DEFAULT), H5Dclose);
  const bool written = set.valid() && (values.empty() || H5Dwrite(set, type_of<T>(), H5S_ALL, H5S_ALL,
                                                                  H5P_DEFAULT, values.data()) >= 0);
  if (!set.give_back() || !written) return error(name, "cannot write (is the disk full?)");
  return Done{};
}

namespace {

/// Creates a growing dataset. Its chunks are as large as the first rows, within bounds.
hid_t make_growing(hid_t file, const std::string& name, hid_t type, hsize_t rows, hsize_t columns, int axes) {
  constexpr hsize_t kFewest = 64, kChunkBytes = 1 << 20;
  const hsize_t most = std::max<hsize_t>(kChunkBytes / (columns * H5Tget_size(type)), kFewest);
  const hsize_t chunk[2] = {std::clamp(rows, kFewest, most), columns}, none[2] = {0, columns},
                any[2] = {H5S_UNLIMITED, columns};
  const Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose), layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose),
      space(H5Screate_simple(axes, none, any), H5Sclose);
  H5Pset_create_intermediate_group(links, 1);
  H5Pset_chunk(layout, axes, chunk);
  H5Pset_shuffle(layout);
  H5Pset_deflate(layout, 3);
  H5Pset_fletcher32(layout);
  return H5Dcreate2(file, name.c_str(), type, space, links, layout, H5P_DEFAULT);
}

/// Appends rows.
bool add_rows(hid_t set, hid_t type, hsize_t rows, hsize_t columns, int axes, const void* values) {
  hsize_t begin[2] = {0, 0};
  const Handle before(H5Dget_space(set), H5Sclose);
  if (!before.valid() || H5Sget_simple_extent_dims(before, begin, nullptr) != axes) return false;
  begin[1] = 0;
  const hsize_t size[2] = {rows, columns}, whole[2] = {begin[0] + rows, columns};
  if (H5Dset_extent(set, whole) < 0) return false;
  const Handle file_space(H5Dget_space(set), H5Sclose),
      memory_space(H5Screate_simple(axes, size, nullptr), H5Sclose);
  return H5Sselect_hyperslab(file_space, H5S_SELECT_SET, begin, nullptr, size, nullptr) >= 0 &&
         H5Dwrite(set, type, memory_space, file_space, H5P_DEFAULT, values) >= 0;
}

}  // namespace

template <class T>
Status Hdf5File::append(const std::string& name, std::span<const T> values, std::size_t columns) {
  TURGOR_ASSERT(values.size() % columns == 0, "every row of a dataset is whole");
  const hsize_t rows = values.size() / columns;
  const int axes = columns == 1 ? 1 : 2;
  Handle set(has(name) ? H5Dopen2(id_, name.c_str(), H5P_DEFAULT)
                       : make_growing(id_, name, type_of<T>(), rows, columns, axes),
             H5Dclose);
  const bool written =
      set.valid() && (rows == 0 || add_rows(set, type_of<T>(), rows, columns, axes, values.data()));
  if (!set.give_back() || !written) return error(name, "cannot write (is the disk full?)");
  return Done{};
}

Status Hdf5File::write_text(const std::string& name, const std::string& text) {
  const Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose), type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Pset_create_intermediate_group(links, 1);
  H5Tset_size(type, text.size() + 1);  // HDF5 has no empty strings
  H5Tset_cset(type, H5T_CSET_UTF8);
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  Handle set(H5Dcreate2(id_, name.c_str(), type, space, links, H5P_DEFAULT, H5P_DEFAULT), H5Dclose);
  const bool written = set.valid() && H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.c_str()) >= 0;
  if (!set.give_back() || !written) return error(name, "cannot write (is the disk full?)");
  return Done{};
}

Status Hdf5File::make_group(const std::string& name) {
  const Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(links, 1);
  Handle group(H5Gcreate2(id_, name.c_str(), links, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  if (!group.valid() || !group.give_back()) return error(name, "cannot write (is the disk full?)");
  return Done{};
}

Status Hdf5File::write_attribute(const std::string& name, const std::string& attribute, std::int64_t type,
                                 std::int64_t space, const void* value) {
  Handle object(H5Oopen(id_, name.c_str(), H5P_DEFAULT), H5Oclose);
  Handle made(H5Acreate2(object, attribute.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  const bool written = made.valid() && H5Awrite(made, type, value) >= 0;
  if (!made.give_back() || !object.give_back() || !written)
    return error(name, "cannot write (is the disk full?)");
  return Done{};
}

Status Hdf5File::write_attribute(const std::string& name, const std::string& attribute,
                                 const std::string& text) {
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose), space(H5Screate(H5S_SCALAR), H5Sclose);
  H5Tset_size(type, text.size() + 1);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return write_attribute(name, attribute, type, space, text.c_str());
}

Status Hdf5File::write_ascii_attribute(const std::string& name, const std::string& attribute,
                                       const std::string& text) {
  TURGOR_ASSERT(!text.empty(), "HDF5 knows no empty text");
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose), space(H5Screate(H5S_SCALAR), H5Sclose);
  H5Tset_size(type, text.size());
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  return write_attribute(name, attribute, type, space, text.data());
}

Status Hdf5File::write_attribute(const std::string& name, const std::string& attribute,
                                 std::span<const std::int64_t> numbers) {
  const hsize_t count = numbers.size();
  const Handle space(count == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &count, nullptr), H5Sclose);
  return write_attribute(name, attribute, H5T_NATIVE_INT64, space, numbers.data());
}

Status Hdf5File::flush() {
  if (H5Fflush(id_, H5F_SCOPE_GLOBAL) < 0) return error("flush", "cannot write (is the disk full?)");
  return Done{};
}

Status Hdf5File::close() {
  if (Status flushed = flush(); !flushed) return flushed;
  if (H5Fclose(std::exchange(id_, -1)) < 0) return error("close", "cannot write (is the disk full?)");
  return Done{};
}

bool Hdf5File::has(const std::string& name) const {
  silence();
  const Handle set(H5Dopen2(id_, name.c_str(), H5P_DEFAULT), H5Dclose);
  return set.valid();
}

Result<std::size_t> Hdf5File::count(const std::string& name, std::size_t most) const {
  silence();
  const Handle set(H5Dopen2(id_, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!set.valid()) return error(name, "is missing");
  const Handle space(H5Dget_space(set), H5Sclose);
  const hssize_t points = space.valid() ? H5Sget_simple_extent_npoints(space) : -1;
  if (points < 0 || std::size_t(points) > most)
    return error(name, fmt::format("expected at most {} values, found {}", most, points));
  return std::size_t(points);
}

template <class T>
Result<std::vector<T>> Hdf5File::read(const std::string& name, std::size_t expected) const {
  const Result<std::size_t> found = count(name, std::max<std::size_t>(expected, 1) * 1024);
  if (!found) return found.error();
  if (*found != expected) return error(name, fmt::format("expected {} values, found {}", expected, *found));
  const Handle set(H5Dopen2(id_, name.c_str(), H5P_DEFAULT), H5Dclose);
  const Handle type(H5Dget_type(set), H5Tclose);
  const H5T_class_t expected_class = H5Tget_class(type_of<T>());
  if (!type.valid() || H5Tget_class(type) != expected_class || H5Tget_size(type) != sizeof(T))
    return error(name, "the values have an unexpected type");
  std::vector<T> values(expected);
  if (expected > 0 && H5Dread(set, type_of<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
    return error(name, "the values are damaged");
  return values;
}

Result<std::string> Hdf5File::read_text(const std::string& name) const {
  constexpr std::size_t kLongest = 1 << 26;  // bytes
  silence();
  const Handle set(H5Dopen2(id_, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!set.valid()) return error(name, "is missing");
  const Handle type(H5Dget_type(set), H5Tclose), space(H5Dget_space(set), H5Sclose);
  const bool is_text = type.valid() && H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0 &&
                       H5Sget_simple_extent_npoints(space) == 1 && H5Tget_size(type) <= kLongest;
  if (!is_text) return error(name, "expected a text, found something else");
  std::string text(H5Tget_size(type), '\0');
  if (H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()) < 0)
    return error(name, "the text is damaged");
  text.resize(std::min(text.size(), text.find('\0')));
  return text;
}

std::string Hdf5File::read_attribute(const std::string& name, const std::string& attribute) const {
  constexpr std::size_t kLongest = 1 << 16;  // bytes
  silence();
  const Handle made(H5Aopen_by_name(id_, name.c_str(), attribute.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                    H5Aclose);
  if (!made.valid()) return "";
  const Handle type(H5Aget_type(made), H5Tclose), space(H5Aget_space(made), H5Sclose);
  if (!type.valid() || H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) != 0) return "";
  if (H5Sget_simple_extent_npoints(space) != 1 || H5Tget_size(type) > kLongest) return "";
  std::string text(H5Tget_size(type), '\0');
  if (H5Aread(made, type, text.data()) < 0) return "";
  text.resize(std::min(text.size(), text.find('\0')));
  return text;
}

std::vector<std::int64_t> Hdf5File::read_numbers(const std::string& name,
                                                 const std::string& attribute) const {
  constexpr hssize_t kMost = 1024;
  silence();
  const Handle made(H5Aopen_by_name(id_, name.c_str(), attribute.c_str(), H5P_DEFAULT, H5P_DEFAULT),
                    H5Aclose);
  if (!made.valid()) return {};
  const Handle type(H5Aget_type(made), H5Tclose), space(H5Aget_space(made), H5Sclose);
  const hssize_t count = space.valid() ? H5Sget_simple_extent_npoints(space) : -1;
  if (!type.valid() || H5Tget_class(type) != H5T_INTEGER || count < 0 || count > kMost) return {};
  std::vector<std::int64_t> numbers(std::size_t(count), 0);
  if (H5Aread(made, H5T_NATIVE_INT64, numbers.data()) < 0) return {};
  return numbers;
}

std::vector<std::string> Hdf5File::datasets() const {
  std::vector<std::string> names;
  const H5O_iterate_t add = [](hid_t, const char* name, const H5O_info_t* object, void* all) {
    if (object->type == H5O_TYPE_DATASET)
      static_cast<std::vector<std::string>*>(all)->push_back(std::string("/") + name);
    return 0;
  };
  H5Ovisit2(id_, H5_INDEX_NAME, H5_ITER_INC, add, &names, H5O_INFO_BASIC);
  return names;
}

// NOLINTBEGIN(bugprone-macro-parentheses): T is a type
#define TURGOR_HDF5_TYPE(T)                                                                             \
  template Status Hdf5File::write<T>(const std::string&, std::span<const T>, std::size_t, Hdf5Packing); \
  template Status Hdf5File::append<T>(const std::string&, std::span<const T>, std::size_t);             \
  template Result<std::vector<T>> Hdf5File::read<T>(const std::string&, std::size_t) const;
// NOLINTEND(bugprone-macro-parentheses)
TURGOR_HDF5_TYPE(float)
TURGOR_HDF5_TYPE(double)
TURGOR_HDF5_TYPE(std::uint8_t)
TURGOR_HDF5_TYPE(std::int32_t)
TURGOR_HDF5_TYPE(std::int64_t)
TURGOR_HDF5_TYPE(std::uint64_t)
#undef TURGOR_HDF5_TYPE

}  // namespace turgor

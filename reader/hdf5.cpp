// HDF5 loops forever, exhausts memory or crashes on some damaged files.
#include <algorithm>
#include <cstddef>
#include <new>

#include <hdf5.h>

#include "reader/tasks.hpp"

namespace turgor {

namespace {

constexpr std::size_t kLargestChunk = std::size_t{64}
                                      << 20;  // bytes; chunks of this program have one megabyte

/// True if the last call of HDF5 failed because it got no memory. Every call erases the error before it.
bool is_out_of_memory() {
  bool found = false;
  const H5E_walk2_t find = [](unsigned, const H5E_error2_t* error, void* result) {
    *static_cast<bool*>(result) |= error->min_num == H5E_NOSPACE;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, find, &found);
  return found;
}

/// True if the values of a dataset need no more memory than themselves and one chunk.
bool is_sound(hid_t set, hid_t layout, hid_t type, hid_t space) {
  if (H5Pget_layout(layout) != H5D_CHUNKED) return true;
  hsize_t chunk[H5S_MAX_RANK] = {}, found = 0;
  std::size_t bytes = H5Tget_size(type);
  for (int axis = H5Pget_chunk(layout, H5S_MAX_RANK, chunk) - 1; axis >= 0 && bytes <= kLargestChunk; axis--)
    bytes *= std::min<hsize_t>(chunk[axis], kLargestChunk + 1);
  return bytes <= kLargestChunk && H5Dget_num_chunks(set, space, &found) >= 0;
}

/// Closes all it opens: a recording has a hundred thousand datasets, and each open identifier takes memory.
bool is_sound(hid_t file, const char* name, bool& out_of_memory) {
  const hid_t set = H5Dopen2(file, name, H5P_DEFAULT);
  hid_t layout = H5I_INVALID_HID, type = H5I_INVALID_HID, space = H5I_INVALID_HID;
  const bool sound = set >= 0 && (layout = H5Dget_create_plist(set)) >= 0 && (type = H5Dget_type(set)) >= 0 &&
                     (space = H5Dget_space(set)) >= 0 && is_sound(set, layout, type, space);
  out_of_memory = !sound && is_out_of_memory();
  H5Sclose(space), H5Tclose(type), H5Pclose(layout), H5Dclose(set);  // no effect on invalid ones
  return sound;
}

/// Ends the walk at a dataset that is not sound.
herr_t look_at(hid_t file, const char* name, const H5O_info_t* object, void* out_of_memory) {
  if (object->type != H5O_TYPE_DATASET) return 0;
  return is_sound(file, name, *static_cast<bool*>(out_of_memory)) ? 0 : -1;
}

}  // namespace

bool walk_through_hdf5(const char* path) {
  H5dont_atexit();  // the process ends without closing
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  bool out_of_memory = false;
  const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
  if (file >= 0 &&
      H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_NATIVE, look_at, &out_of_memory, H5O_INFO_BASIC) >= 0)
    return true;
  if (out_of_memory || is_out_of_memory()) throw std::bad_alloc();
  return false;
}

}  // namespace turgor

// Any bytes as a CT, as labels and as vectors, in every format: an error or a volume whose samples fit its
// grid, never a crash.
#include <cmath>
#include <cstdint>
#include <fstream>

#include "fuzz_input.hpp"
#include "tests/folders.hpp"
#include "turgor/io/ct.hpp"

namespace {

namespace fs = std::filesystem;

template <class T>
void check(const turgor::Volume<T>& volume) {
  require(volume.samples.size() == sample_count(volume.grid));
  for (int axis = 0; axis < 3; axis++)
    require(volume.grid.spacing[axis] > 0 && std::isfinite(volume.grid.spacing[axis]));
  require(determinant(volume.grid.axes) > 0.9);
}

template <class T>
void check(const turgor::Result<T>& read) {
  if (!read)
    require(!read.error().message.empty());
  else if constexpr (requires { read->ct; })
    check(read->ct);
  else if constexpr (requires { read->labels; })
    check(read->labels);
  else
    check(*read);
}

/// The name that makes a reader look at the bytes as what they seem to be.
const char* name_for(const std::string& bytes) {
  if (bytes.starts_with("NRRD")) return "a.nrrd";
  if (bytes.starts_with("\x1f\x8b")) return "a.nii.gz";
  if (bytes.size() > 132 && bytes.compare(128, 4, "DICM") == 0) return "a.dcm";
  return bytes.find("NDims") < 2048 ? "a.mha" : "a.nii";
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  static const fs::path folder = turgor::test::fresh_folder();
  static const turgor::Exec exec(1);
  const std::string text(reinterpret_cast<const char*>(bytes), size);
  const fs::path file = folder / name_for(text);
  std::ofstream(file, std::ios::binary) << text;
  check(read_ct(exec, file));
  if (file.extension() != ".dcm") {
    check(turgor::read_labels(file));
    check(turgor::read_vectors(file));
  }
  fs::remove(file);
  return 0;
}

// Any bytes as a triangle surface, in every format: an error or triangles between vertices, never a crash.
#include <cmath>
#include <cstdint>
#include <fstream>

#include "fuzz_input.hpp"
#include "tests/folders.hpp"
#include "turgor/io/mesh/surface_files.hpp"

namespace {

namespace fs = std::filesystem;

void check(const turgor::TriMesh& mesh) {
  require(!mesh.triangles.empty());
  for (const turgor::Vec3 x : mesh.vertices)
    require(std::isfinite(x.x) && std::isfinite(x.y) && std::isfinite(x.z));
  for (const auto [a, b, c] : mesh.triangles) {
    for (const int v : {a, b, c}) require(v >= 0 && std::size_t(v) < mesh.vertices.size());
    require(a != b && b != c && c != a);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  static const fs::path folder = turgor::test::fresh_folder();
  const fs::path file = folder / "mesh.stl";
  std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char*>(bytes), std::streamsize(size));
  const turgor::Result<turgor::ReadSurface> read = turgor::read_surface(file);
  read ? check(read->mesh) : require(read.error().message.find("/mesh.stl") != std::string::npos);
  return 0;
}

// Any bytes as a mesh of tetrahedra or hexahedra, in every format: an error or a mesh that can be computed
// with, never a crash. TetGen's pair of files is one input, parted by a line "#pair".
#include <cstdint>
#include <fstream>

#include "fuzz_input.hpp"
#include "tests/folders.hpp"
#include "turgor/io/mesh/solid_files.hpp"

namespace {

namespace fs = std::filesystem;

void check(const turgor::SolidMesh& mesh) {
  require(mesh.corners == 4 || mesh.corners == 8);
  require(!mesh.elements.empty() && mesh.elements.size() % std::size_t(mesh.corners) == 0);
  require(mesh.regions.empty() || mesh.regions.size() == element_count(mesh));
  for (const int v : mesh.elements) require(v >= 0 && std::size_t(v) < mesh.vertices.size());
  for (std::size_t e = 0; e < element_count(mesh); e++) require(volume(mesh, e) > 0);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  static const fs::path folder = turgor::test::fresh_folder();
  const std::string text(reinterpret_cast<const char*>(bytes), size);
  const std::size_t pair = std::min(text.find("#pair\n"), size);
  const fs::path file = folder / "mesh.node";
  std::ofstream(file, std::ios::binary) << text.substr(0, pair);
  std::ofstream(folder / "mesh.ele", std::ios::binary) << text.substr(pair);
  const turgor::Result<turgor::ReadSolid> read = turgor::read_solid(file);
  read ? check(read->mesh) : require(read.error().message.find("/mesh.") != std::string::npos);
  return 0;
}

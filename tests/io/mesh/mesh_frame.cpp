// Patient frames that files declare, in files of the writers of VTK 9.7 and as 3D Slicer writes them.
#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "tests/io/damage.hpp"
#include "tests/io/mesh/solid_samples.hpp"
#include "turgor/io/mesh/solid_files.hpp"
#include "turgor/io/mesh/surface_files.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;
using test::damaged;

const fs::path kCorpus = fs::path(TURGOR_SOURCE_DIR) / "tests" / "fuzz" / "corpus";

std::vector<std::string> notes_of(const fs::path& file) {
  if (is_surface_file(file)) {
    const Result<ReadSurface> read = read_surface(file);
    return read ? read->notes : std::vector{read.error().message};
  }
  const Result<ReadSolid> read = read_solid(file);
  return read ? read->notes : std::vector{read.error().message};
}

/// Number of notes about the frame; another one is an error.
int frame_notes(const std::string& bytes) {
  const fs::path file = test::fresh_folder() / "mesh";
  test::write(file, bytes);
  int count = 0;
  for (const std::string& note : notes_of(file)) {
    const bool is_frame = note.starts_with("the file declares RAS, but bodies are in LPS");
    EXPECT_TRUE(is_frame || note.starts_with("dropped: 1 node")) << note;
    count += is_frame;
  }
  return count;
}

// A file that declares RAS in the field SPACE gives one note, in every format and encoding of VTK.
TEST(MeshFrame, RasFieldIsNoted) {
  for (const char* name :
       {"surface/ras-appended.vtp", "surface/ras-appended-zlib.vtp", "surface/ras-inline.vtp",
        "surface/ras-binary.vtk", "solid/ras-text.vtu", "solid/ras-inline-zlib.vtu", "solid/ras-appended.vtu",
        "solid/ras-appended-base64-zlib.vtu", "solid/ras-binary.vtk", "solid/ras-text.vtk"}) {
    SCOPED_TRACE(name);
    EXPECT_EQ(frame_notes(test::bytes_of(kCorpus / name)), 1);
  }
}

// The same files with LPS in the field give none, whatever their title says.
TEST(MeshFrame, LpsFieldIsNotNoted) {
  const std::string kRas("RAS\0", 4), kLps("LPS\0", 4);
  const struct {
    const char* name;
    std::string from, to;
  } files[] = {{"surface/ras-appended.vtp", kRas, kLps},
               {"surface/ras-inline.vtp", "BAAAAFJBUwA=", "BAAAAExQUwA="},
               {"solid/ras-appended.vtu", kRas, kLps},
               {"solid/ras-text.vtu", "82 65 83", "76 80 83"},
               {"solid/ras-binary.vtk", "\xC3RAS", "\xC3LPS"},
               {"solid/ras-text.vtk", "string\nRAS", "string\nLPS"}};
  for (const auto& file : files) {
    SCOPED_TRACE(file.name);
    EXPECT_EQ(frame_notes(damaged({test::bytes_of(kCorpus / file.name), file.from, file.to, ""})), 0);
  }
}

// A title or a comment of a solid mesh that declares RAS gives a note.
TEST(MeshFrame, TitleOfSolidIsNoted) {
  const std::string slicer = "3D Slicer output. SPACE=";
  EXPECT_EQ(frame_notes(damaged({test::vtk(), "two tetrahedra", slicer + "RAS", ""})), 1);
  EXPECT_EQ(frame_notes(damaged({test::vtk(), "two tetrahedra", slicer + "LPS", ""})), 0);
  EXPECT_EQ(frame_notes(damaged({test::vtk_binary(), "two", slicer + "RAS", ""})), 1);
  EXPECT_EQ(frame_notes(damaged({test::medit(), "made by hand", "SPACE=RAS", ""})), 1);
  for (const std::string& sample : {test::vtk(), test::vtu(), test::medit(), test::gmsh_2()})
    EXPECT_EQ(frame_notes(sample), 0);
}

// A field of another form declares no frame.
TEST(MeshFrame, DamagedFieldIsIgnored) {
  const std::string text = test::bytes_of(kCorpus / "solid/ras-text.vtu");
  for (const char* field : {"82 65 83", "82 65 83 0 0", "", "R A S 0", "999 65 83 0"})
    EXPECT_EQ(frame_notes(damaged({text, "82 65 83 0", field, ""})), 0) << field;
}

}  // namespace
}  // namespace turgor

// Derived DICOM series: the elements by which viewers associate it with its source.
#include "tests/io/dicom/dicom_series.hpp"

namespace turgor {
namespace {

using test::bytes_of;
using test::Series;

namespace fs = std::filesystem;

io::DicomElements elements_of(const fs::path& file) {
  io::DicomElements found;
  io::FileWindow window(file);
  const Status read = io::find_elements(window, found);
  EXPECT_TRUE(read) << read.error().message;
  return found;
}

struct Derived {
  Series source;
  fs::path path;

  /// A series of the source's patient with slices that are twice as thick.
  Derived() : path(source.folder / "derived") {
    source.set_every(0x0008, 0x0020, "20261122");
    source.set_every(0x0010, 0x0020, "4711");
    source.set_every(0x0010, 0x0040, "F");
    const Result<CtFile> read = source.read();
    EXPECT_TRUE(read);
    CtVolume now{read->ct.grid, {}};
    now.grid.size.z = 3, now.grid.spacing.z *= 2;
    now.grid.origin = point_at(read->ct.grid, {0, 0, 0.4});
    now.samples.assign(sample_count(now.grid), 7);
    const Status written = write_dicom(Exec(2), path, now, read->origin);
    EXPECT_TRUE(written) << written.error().message;
  }
  fs::path slice(int number) const { return path / ("slice-0000" + std::to_string(number) + ".dcm"); }
};

// A derived series keeps patient, study and frame of reference and gets its own series UID.
TEST(DicomDerived, KeepsPatientStudyAndFrameOfReference) {
  const Derived d;
  const io::DicomElements source = elements_of(d.source.slice(1)), derived = elements_of(d.slice(1));
  for (const auto& [group, element] :
       {std::pair(0x0008, 0x0020), std::pair(0x0010, 0x0010), std::pair(0x0010, 0x0020),
        std::pair(0x0010, 0x0040), std::pair(0x0020, 0x000d), std::pair(0x0020, 0x0052)}) {
    const auto g = std::uint16_t(group), e = std::uint16_t(element);
    EXPECT_FALSE(source.value(g, e).empty());
    EXPECT_EQ(derived.value(g, e), source.value(g, e)) << group << ' ' << element;
  }
  EXPECT_NE(derived.value(0x0020, 0x000e), source.value(0x0020, 0x000e));
  EXPECT_TRUE(derived.value(0x0008, 0x0008).starts_with("DERIVED"));
}

// Every derived slice references the nearest image of its source.
TEST(DicomDerived, SlicesReferenceNearestSource) {
  const Derived d;
  for (int k = 0; k < 3; k++) {  // at 0.4, 2.4 and 4.4 slices of the source
    const std::string bytes = bytes_of(d.slice(k + 1));
    for (int n = 1; n <= 6; n++) {
      const io::DicomElements source = elements_of(d.source.slice(n));
      const std::string uid(source.value(0x0008, 0x0018));
      EXPECT_EQ(bytes.find(uid) != bytes.npos, n == 2 * k + 1) << k << ' ' << n;
    }
  }
}

// A derived series in the folder of its source is listed and can be selected.
TEST(DicomDerived, ReadableBesideSource) {
  const Derived d;
  for (const auto& entry : fs::directory_iterator(d.path))
    fs::copy(entry.path(), d.source.path / ("derived-" + entry.path().filename().string()));
  EXPECT_REFUSED(d.source.read(), "Turgor: deformed");  // two series: one must be selected
  const Result<CtFile> first = d.source.read("1"), second = d.source.read("2");
  ASSERT_TRUE(first && second);
  const CtFile& derived = first->ct.grid.size.z == 3 ? *first : *second;
  EXPECT_EQ(derived.ct.samples, std::vector<std::int16_t>(9 * 7 * 3, 7));
}

}  // namespace
}  // namespace turgor

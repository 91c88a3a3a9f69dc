// Enhanced images and rare transfer syntaxes, written by GDCM.
#include <algorithm>
#include <fstream>
#include <numeric>
#include <optional>

#include <fmt/format.h>
#include <gdcmImageChangeTransferSyntax.h>
#include <gdcmImageReader.h>
#include <gdcmImageWriter.h>
#include <gdcmReader.h>
#include <gdcmSequenceOfItems.h>
#include <gdcmWriter.h>

#include "tests/io/dicom/dicom_series.hpp"

namespace turgor {
namespace {

using test::fresh_folder;
using test::Series;

namespace fs = std::filesystem;

void transcode(const fs::path& file, gdcm::TransferSyntax::TSType syntax) {
  gdcm::Reader reader;
  reader.SetFileName(file.c_str());
  ASSERT_TRUE(reader.Read());
  if (syntax == gdcm::TransferSyntax::ExplicitVRBigEndian) {
    gdcm::ImageReader images;
    images.SetFileName(file.c_str());
    ASSERT_TRUE(images.Read());
    gdcm::ImageChangeTransferSyntax change;
    change.SetTransferSyntax(syntax);
    change.SetInput(images.GetImage());
    ASSERT_TRUE(change.Change());
    gdcm::ImageWriter writer;
    writer.SetFile(images.GetFile());
    writer.SetImage(change.GetOutput());
    writer.SetFileName(file.c_str());
    ASSERT_TRUE(writer.Write());
    return;
  }
  reader.GetFile().GetHeader().SetDataSetTransferSyntax(syntax);
  gdcm::Writer writer;
  writer.SetFile(reader.GetFile());
  writer.SetFileName(file.c_str());
  ASSERT_TRUE(writer.Write());
}

// Big-endian and deflated files give the same volume.
TEST(DicomEnhanced, BigEndianAndDeflatedGiveSameVolume) {
  using gdcm::TransferSyntax;
  for (const TransferSyntax::TSType syntax :
       {TransferSyntax::ExplicitVRBigEndian, TransferSyntax::DeflatedExplicitVRLittleEndian}) {
    const Series s;
    for (int n = 1; n <= 6; n++) transcode(s.slice(n), syntax);
    io::DicomElements elements;
    io::FileWindow window(s.slice(2));
    ASSERT_TRUE(io::find_elements(window, elements));
    EXPECT_EQ(elements.transfer_syntax, TransferSyntax::GetTSString(syntax));
    const auto read = s.read();
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->ct.samples, s.ct.samples);
    EXPECT_LT(norm(point_at(read->ct.grid, {8, 6, 5}) - point_at(s.ct.grid, {8, 6, 5})), 1e-8);
  }
}

// A truncated deflated file is rejected and named; a damaged one does not crash the reader.
TEST(DicomEnhanced, DamagedDeflatedFileIsNamed) {
  const Series s;
  transcode(s.slice(4), gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian);
  const std::string whole = test::bytes_of(s.slice(4));
  for (std::size_t kept = whole.size() - 16; kept > 200;
       kept -= std::min<std::size_t>(kept, 97)) {  // keeps the checksum out of the truncation
    test::write(s.slice(4), whole.substr(0, kept));
    EXPECT_REFUSED(s.read(), "slice-00004.dcm");
  }
  for (std::size_t at = 400; at < whole.size(); at += 31) {
    std::string damaged = whole;
    damaged[at] = char(damaged[at] ^ 0x5a);
    test::write(s.slice(4), damaged);
    (void)s.read();  // gives a volume or an error
  }
}

/// Builder for the elements of a data set.
struct Writing {
  gdcm::DataSet set;

  void text(std::uint16_t group, std::uint16_t element, gdcm::VR::VRType vr, std::string value) {
    if (value.size() % 2) value += vr == gdcm::VR::UI ? '\0' : ' ';
    gdcm::DataElement e{gdcm::Tag(group, element)};
    e.SetVR(vr);
    e.SetByteValue(value.data(), std::uint32_t(value.size()));
    set.Replace(e);
  }
  void integer(std::uint16_t group, std::uint16_t element, std::uint16_t value) {
    text(group, element, gdcm::VR::US, std::string(reinterpret_cast<const char*>(&value), 2));
  }
  void items(std::uint16_t group, std::uint16_t element, const std::vector<gdcm::DataSet>& sets) {
    gdcm::SmartPointer<gdcm::SequenceOfItems> sequence = new gdcm::SequenceOfItems;
    sequence->SetLengthToUndefined();
    for (const gdcm::DataSet& nested : sets) {
      gdcm::Item item;
      item.SetVLToUndefined();
      item.SetNestedDataSet(nested);
      sequence->AddItem(item);
    }
    gdcm::DataElement e{gdcm::Tag(group, element)};
    e.SetVR(gdcm::VR::SQ);
    e.SetValue(*sequence);
    e.SetVLToUndefined();
    set.Replace(e);
  }
};

using gdcm::VR;

std::string decimals(std::initializer_list<double> values) {
  std::string text;
  for (const double v : values) text += (text.empty() ? "" : "\\") + fmt::format("{:.13g}", v);
  return text;
}

gdcm::DataSet measures(const Grid& grid) {
  Writing w;
  w.text(0x0018, 0x0050, VR::DS, decimals({grid.spacing.z * 1e3}));
  w.text(0x0028, 0x0030, VR::DS, decimals({grid.spacing.y * 1e3, grid.spacing.x * 1e3}));
  return w.set;
}

gdcm::DataSet orientation(const Grid& grid) {
  const Vec3d i = grid.axes.column[0], j = grid.axes.column[1];
  Writing w;
  w.text(0x0020, 0x0037, VR::DS, decimals({i.x, i.y, i.z, j.x, j.y, j.z}));
  return w.set;
}

gdcm::DataSet position(const Grid& grid, int k) {
  const Vec3d p = point_at(grid, {0, 0, double(k)}) * 1e3;
  Writing w;
  w.text(0x0020, 0x0032, VR::DS, decimals({p.x, p.y, p.z}));
  return w.set;
}

gdcm::DataSet scale(double slope, double intercept) {
  Writing w;
  w.text(0x0028, 0x1052, VR::DS, decimals({intercept}));
  w.text(0x0028, 0x1053, VR::DS, decimals({slope}));
  return w.set;
}

struct Enhanced {
  CtVolume ct = test::make_ct();
  std::vector<int> order{3, 0, 5, 1, 4, 2};  // slice index of each frame in the file
  gdcm::TransferSyntax::TSType syntax = gdcm::TransferSyntax::ExplicitVRLittleEndian;
  int said_frames = 6;

  /// Writes the file. Samples of odd frames are stored with twice their value.
  void write(const fs::path& file) const {
    Writing image;
    image.text(0x0008, 0x0016, VR::UI, "1.2.840.10008.5.1.4.1.1.2.1");
    image.text(0x0008, 0x0018, VR::UI, "2.25.77");
    image.text(0x0008, 0x0060, VR::CS, "CT");
    image.text(0x0010, 0x0010, VR::PN, "Many^Frames");
    image.text(0x0020, 0x000d, VR::UI, "2.25.78");
    image.text(0x0020, 0x000e, VR::UI, "2.25.79");
    image.integer(0x0028, 0x0002, 1);
    image.text(0x0028, 0x0004, VR::CS, "MONOCHROME2");
    image.text(0x0028, 0x0008, VR::IS, std::to_string(said_frames));
    image.integer(0x0028, 0x0010, std::uint16_t(ct.grid.size.y));
    image.integer(0x0028, 0x0011, std::uint16_t(ct.grid.size.x));
    for (const auto& [element, value] : {std::pair(0x0100, 16), {0x0101, 16}, {0x0102, 15}, {0x0103, 1}})
      image.integer(0x0028, std::uint16_t(element), std::uint16_t(value));
    Writing shared;
    shared.items(0x0020, 0x9116, {orientation(ct.grid)});
    shared.items(0x0028, 0x9110, {measures(ct.grid)});
    image.items(0x5200, 0x9229, {shared.set});
    image.items(0x5200, 0x9230, frames());
    image.text(0x7fe0, 0x0010, VR::OW, pixels());
    gdcm::Writer writer;
    writer.GetFile().SetDataSet(image.set);
    writer.GetFile().GetHeader().SetDataSetTransferSyntax(syntax);
    writer.SetFileName(file.c_str());
    ASSERT_TRUE(writer.Write());
  }
  std::vector<gdcm::DataSet> frames() const {
    std::vector<gdcm::DataSet> sets;
    for (std::size_t f = 0; f < order.size(); f++) {
      Writing frame;
      frame.items(0x0020, 0x9113, {position(ct.grid, order[f])});
      frame.items(0x0028, 0x9145, {f % 2 ? scale(0.5, 0) : scale(1, 0)});
      sets.push_back(frame.set);
    }
    return sets;
  }
  std::string pixels() const {
    const std::size_t area = std::size_t(ct.grid.size.x) * std::size_t(ct.grid.size.y);
    std::string bytes;
    for (std::size_t f = 0; f < order.size(); f++)
      for (std::size_t n = 0; n < area; n++) {
        const auto hu = ct.samples[std::size_t(order[f]) * area + n];
        const auto stored = std::int16_t(f % 2 ? 2 * hu : hu);
        bytes.append(reinterpret_cast<const char*>(&stored), 2);
      }
    return bytes;
  }
};

// Frames in any order are sorted by position, and each is scaled by its own slope.
TEST(DicomEnhanced, FramesAreSortedAndScaled) {
  using gdcm::TransferSyntax;
  for (const TransferSyntax::TSType syntax :
       {TransferSyntax::ExplicitVRLittleEndian, TransferSyntax::ImplicitVRLittleEndian,
        TransferSyntax::DeflatedExplicitVRLittleEndian}) {
    Enhanced enhanced;
    enhanced.syntax = syntax;
    const fs::path folder = fresh_folder(), file = folder / "enhanced.dcm";
    enhanced.write(file);
    for (const fs::path& path : {folder, file}) {
      const auto read = read_ct(Exec(2), path);
      ASSERT_TRUE(read) << read.error().message;
      EXPECT_EQ(read->ct.samples, enhanced.ct.samples);
      EXPECT_LT(norm(point_at(read->ct.grid, {8, 6, 5}) - point_at(enhanced.ct.grid, {8, 6, 5})), 1e-8);
      EXPECT_EQ(read->patient, "Many^Frames");
      EXPECT_EQ(read->files, 1);
    }
  }
}

/// Bytes read by this process so far. Empty if the system does not report them.
std::optional<std::size_t> bytes_read() {
  std::ifstream io("/proc/self/io");
  std::string word;
  std::size_t bytes = 0;
  if (!(io >> word >> bytes) || word != "rchar:") return std::nullopt;
  return bytes;
}

// A deflated file is read once for its header and once for all of its frames.
TEST(DicomEnhanced, DeflatedFramesAreReadInOnePass) {
  Enhanced enhanced;
  enhanced.ct = test::make_ct(40);
  enhanced.order.resize(40);
  std::iota(enhanced.order.rbegin(), enhanced.order.rend(), 0);
  enhanced.said_frames = 40;
  enhanced.syntax = gdcm::TransferSyntax::DeflatedExplicitVRLittleEndian;
  const fs::path folder = fresh_folder(), file = folder / "enhanced.dcm";
  enhanced.write(file);
  const std::optional<std::size_t> before = bytes_read();
  if (!before) GTEST_SKIP() << "the system does not report how much was read";
  const auto read = read_ct(Exec(1), file);
  const std::size_t after = *bytes_read();
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->ct.samples, enhanced.ct.samples);
  const auto size = fs::file_size(file);
  EXPECT_LT(after - *before, 8 * size) << " bytes were read of a file of " << size;
}

// Errors for gaps and duplicate positions name the frames by number.
TEST(DicomEnhanced, GapsAndDuplicatesNameFrames) {
  Enhanced gap;
  gap.order = {3, 0, 5, 1, 4, 6};
  gap.ct = test::make_ct(7);
  const fs::path folder = fresh_folder();
  gap.write(folder / "a.dcm");
  EXPECT_REFUSED(read_ct(Exec(2), folder), "a.dcm, frame 4", "a.dcm, frame 1", "missing slices: 1 of 7");
  Enhanced doubled;
  doubled.order = {3, 0, 5, 1, 4, 4};
  doubled.write(folder / "a.dcm");
  EXPECT_REFUSED(read_ct(Exec(2), folder), "frame 5", "frame 6", "same position");
}

// A header whose number of frames differs from its number of positions is rejected.
TEST(DicomEnhanced, RejectsFrameCountMismatch) {
  Enhanced enhanced;
  enhanced.said_frames = 7;
  const fs::path folder = fresh_folder();
  enhanced.write(folder / "a.dcm");
  EXPECT_REFUSED(read_ct(Exec(2), folder), "a.dcm", "7 frames", "without positions in its header");
}

// A number of frames that is no whole number from 1 is rejected, in images and in segmentations.
TEST(DicomEnhanced, DamagedFrameCountIsNamed) {
  const fs::path folder = fresh_folder(), image = folder / "ct" / "a.dcm", labels = folder / "labels.dcm";
  fs::create_directory(image.parent_path());
  for (const char* count : {"abc", "1e10", "0", "-3", "2.5", "nan"}) {
    Enhanced().write(image);
    test::set_value(image, 0x28, 0x08, count);
    EXPECT_REFUSED(read_ct(Exec(2), image.parent_path()),
                   "a.dcm: NumberOfFrames (0028,0008) is no whole number from 1");
    test::write(labels,
                test::bytes_of(fs::path(TURGOR_SOURCE_DIR) / "tests/fuzz/corpus/ct/segmentation.dcm"));
    test::set_value(labels, 0x28, 0x08, count);
    EXPECT_REFUSED(read_labels(labels), "labels.dcm: NumberOfFrames (0028,0008) is no whole number from 1");
  }
}

// A file truncated at any byte is rejected and named.
TEST(DicomEnhanced, TruncatedFileIsNamed) {
  const fs::path folder = fresh_folder();
  Enhanced().write(folder / "a.dcm");
  const std::string whole = test::bytes_of(folder / "a.dcm");
  for (std::size_t kept = whole.size() - 1; kept > 500; kept -= std::min<std::size_t>(kept, 61)) {
    test::write(folder / "a.dcm", whole.substr(0, kept));
    EXPECT_REFUSED(read_ct(Exec(2), folder), "a.dcm");
  }
}

// Each slice of a derived series references the frame of its source.
TEST(DicomEnhanced, DerivedSlicesReferenceFrames) {
  const fs::path folder = fresh_folder();
  Enhanced().write(folder / "a.dcm");
  const auto read = read_ct(Exec(2), folder / "a.dcm");
  ASSERT_TRUE(read);
  ASSERT_TRUE(write_dicom(Exec(2), folder / "derived", read->ct, read->origin));
  // slice 1 of the volume is frame 2 of the file
  const std::string bytes = test::bytes_of(folder / "derived" / "slice-00001.dcm");
  const std::size_t item = bytes.find("2.25.77");
  ASSERT_NE(item, bytes.npos);
  EXPECT_NE(bytes.find(std::string("\x08\0\x60\x11IS\2\0", 8) + "2 ", item), bytes.npos);
  EXPECT_NE(bytes.find("1.2.840.10008.5.1.4.1.1.2.1"), bytes.npos);
}

}  // namespace
}  // namespace turgor

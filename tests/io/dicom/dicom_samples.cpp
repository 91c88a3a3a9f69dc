// Samples of slices: transfer syntaxes, scales, padding, bits.
#include "tests/io/dicom/dicom_series.hpp"
#include "turgor/geometry/hounsfield.hpp"

namespace turgor {
namespace {

using test::bytes_of;
using test::fresh_folder;
using test::Series;
using test::set_value;
using test::write;

namespace fs = std::filesystem;

const Exec kExec(2);

// Slope and intercept scale the samples; a slope of NaN, zero or text is ignored.
TEST(DicomSamples, AppliesSlopeAndIntercept) {
  const Series s;
  s.set_every(0x28, 0x1053, "2");
  s.set_every(0x28, 0x1052, "-1024");
  auto read = s.read();
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->ct.samples[5], 2 * s.ct.samples[5] - 1024);
  for (const char* slope : {"NaN", "0", "nonsense"}) {
    s.set_every(0x28, 0x1053, slope);
    read = s.read();
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->ct.samples, s.ct.samples) << slope;
  }
}

const fs::path kCorpus = fs::path(TURGOR_SOURCE_DIR) / "tests" / "fuzz" / "corpus" / "ct";

// Every transfer syntax gives the same samples.
TEST(DicomSamples, TransferSyntaxesGiveSameSamples) {
  const std::filesystem::path folder = fresh_folder();
  std::vector<std::int16_t> first;
  for (const char* name : {"explicit.dcm", "implicit.dcm", "rle.dcm", "jpeg.dcm", "jpegls.dcm", "j2k.dcm"}) {
    fs::create_directory(folder / name);
    fs::copy(kCorpus / name, folder / name);
    const auto read = read_ct(kExec, folder / name);
    ASSERT_TRUE(read) << read.error().message;
    if (first.empty()) first = read->ct.samples;
    ASSERT_EQ(read->ct.samples.size(), 256u);
    EXPECT_EQ(read->ct.samples, first) << name;
  }
}

// A damaged or truncated compressed image gives an error message.
TEST(DicomSamples, RejectsDamagedCompressedImage) {
  for (const char* name : {"rle.dcm", "jpeg.dcm", "jpegls.dcm", "j2k.dcm"}) {
    const std::filesystem::path folder = fresh_folder();
    std::string bytes = bytes_of(kCorpus / name);
    const std::size_t pixels = bytes.find(std::string("\xe0\x7f\x10\0", 4), 132);
    ASSERT_NE(pixels, std::string::npos);
    for (std::size_t at = pixels + 28; at < pixels + 60; at++)
      bytes[at] = char(0xa5);  // head of the compressed stream
    write(folder / name, bytes);
    EXPECT_REFUSED(read_ct(kExec, folder / name), name, "decoded");
    write(folder / name, bytes.substr(0, bytes.size() - 20));
    EXPECT_REFUSED(read_ct(kExec, folder / name), name, "truncated");
  }
}

// Samples with the padding value become air.
TEST(DicomSamples, PaddingBecomesAir) {
  const Series s;
  // PixelPaddingValue follows PixelRepresentation (0028,0103), the last element of its group below
  // (0028,1050).
  const std::int16_t pad = s.ct.samples[4];
  for (int number = 1; number <= 6; number++) {
    std::string bytes = bytes_of(s.slice(number));
    const std::size_t at = bytes.find(std::string("\x28\0\x03\x01US", 6), 132);
    ASSERT_NE(at, std::string::npos);
    bytes.insert(at + 10, std::string("\x28\0\x20\x01SS\x02\0", 8) + char(pad & 255) + char(pad >> 8));
    write(s.slice(number), bytes);
  }
  const auto read = s.read();
  ASSERT_TRUE(read) << read.error().message;
  for (std::size_t n = 0; n < s.ct.samples.size(); n++)
    EXPECT_EQ(read->ct.samples[n], s.ct.samples[n] == pad ? kAirHu : s.ct.samples[n]);
}

// Notes count the samples that became air and those that were clamped.
TEST(DicomSamples, PaddingAndClampingAreCounted) {
  const Series s;
  for (int number = 1; number <= 6; number++) {
    std::string bytes = bytes_of(s.slice(number));
    const std::size_t at = bytes.find(std::string("\x28\0\x03\x01US", 6), 132);
    const std::int16_t low = -2000, high = -1500;
    const auto element = [](char low_byte, std::int16_t value) {
      return std::string("\x28\0", 2) + low_byte + std::string("\x01SS\x02\0", 5) + char(value & 255) +
             char(value >> 8);
    };
    bytes.insert(at + 10, element('\x20', low) + element('\x21', high));
    write(s.slice(number), bytes);
  }
  const auto padded = std::count_if(s.ct.samples.begin(), s.ct.samples.end(),
                                    [](int hu) { return hu >= -2000 && hu <= -1500; });
  const auto read = s.read();
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->notes.size(), 1u);
  EXPECT_TRUE(read->notes[0].starts_with(std::to_string(padded) + " samples became air (-1000 HU)"))
      << read->notes[0];
  s.set_every(0x28, 0x1053, "20");
  const auto clamped =
      std::count_if(s.ct.samples.begin(), s.ct.samples.end(), [](int hu) { return hu > 1638 || hu < -2000; });
  const auto scaled = s.read();
  ASSERT_TRUE(scaled) << scaled.error().message;
  ASSERT_EQ(scaled->notes.size(), 3u);  // the third note reports implausible Hounsfield units
  EXPECT_TRUE(scaled->notes[1].starts_with(std::to_string(clamped) +
                                           " samples outside -32768 to 32767 HU were clamped"))
      << scaled->notes[1];
}

// A note reports rounding if the slope is not a whole number.
TEST(DicomSamples, FractionalSlopeIsNoted) {
  const Series s;
  s.set_every(0x28, 0x1053, "0.5");
  const auto read = s.read();
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_EQ(read->notes.size(), 1u);
  EXPECT_NE(read->notes[0].find("rounded to integer Hounsfield units: RescaleSlope 0.5"), std::string::npos)
      << read->notes[0];
}

// Samples that do not start at the lowest bit are rejected.
TEST(DicomSamples, RejectsShiftedHighBit) {
  const Series s;
  s.set_every(0x28, 0x101, std::string("\x0c\0", 2));  // 12 bits, from bit 15 downwards
  EXPECT_REFUSED(s.read(), "HighBit (0028,0102) is 15 with 12 bits stored", "expected 11");
}

// Compressed pixels whose size contradicts the header are rejected before they are decoded.
TEST(DicomSamples, ChecksCompressedSizeBeforeDecoding) {
  for (const char* name : {"jpeg.dcm", "jpegls.dcm", "j2k.dcm"}) {
    const fs::path file = fresh_folder() / name;
    fs::copy(kCorpus / name, file);
    set_value(file, 0x28, 0x10, std::string("\x0f\0", 2));
    EXPECT_REFUSED(read_ct(kExec, file), name, "16 x 15", "compressed pixels 16 x 16");
    set_value(file, 0x28, 0x10, std::string("\x30\x75", 2));
    set_value(file, 0x28, 0x11, std::string("\x30\x75", 2));
    EXPECT_REFUSED(read_ct(kExec, file), name, "30000 x 30000 pixels", "at most 67108864");
  }
}

}  // namespace
}  // namespace turgor

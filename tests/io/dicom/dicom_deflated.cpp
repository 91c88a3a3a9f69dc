// Deflated DICOM files whose inflated data is a thousand times longer than the file. Memory follows the image
// that the header declares, not the length of the data.
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "tests/folders.hpp"
#include "turgor/io/ct.hpp"
#include "turgor/io/dicom/dicom.hpp"
#include "turgor/io/files/deflate.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

std::string little(std::uint64_t value, int bytes) {
  std::string out;
  for (int i = 0; i < bytes; i++) out += char(value >> (8 * i) & 0xff);
  return out;
}

/// Header of an explicit element with a long length.
std::string long_header(std::uint32_t tag, const char* vr, std::uint32_t length) {
  return little(tag >> 16, 2) + little(tag & 0xffff, 2) + vr + little(0, 2) + little(length, 4);
}

std::string short_element(std::uint32_t tag, const char* vr, std::string value) {
  if (value.size() % 2) value += ' ';
  return little(tag >> 16, 2) + little(tag & 0xffff, 2) + vr + little(value.size(), 2) + value;
}

/// A raw deflate stream: zlib's without its header and checksum.
std::string raw_deflated(std::string_view start, std::size_t zeros, std::string_view end) {
  const std::string none(zeros, '\0');
  std::string packed;
  io::deflate({start, none, end}, io::Deflate::kZlib, [&](std::string_view piece) { packed += piece; });
  return packed.substr(2, packed.size() - 6);
}

/// A file whose deflated data set is `start`, that many zeros, and `end`.
fs::path deflated_file(const std::string& start, std::size_t zeros, const std::string& end) {
  std::string syntax = "1.2.840.10008.1.2.1.99";
  const std::string meta = short_element(0x00020010, "UI", syntax);
  const fs::path file = test::fresh_folder() / "bomb.dcm";
  test::write(file, std::string(128, '\0') + "DICM" +
                        short_element(0x00020000, "UL", little(meta.size(), 4)) + meta +
                        raw_deflated(start, zeros, end));
  return file;
}

std::string small_image() {
  return short_element(0x00080060, "CS", "CT") + short_element(0x00200032, "DS", "0\\0\\0") +
         short_element(0x00200037, "DS", "1\\0\\0\\0\\1\\0") + short_element(0x00280002, "US", little(1, 2)) +
         short_element(0x00280010, "US", little(16, 2)) + short_element(0x00280011, "US", little(16, 2)) +
         short_element(0x00280030, "DS", "1\\1") + short_element(0x00280100, "US", little(16, 2)) +
         short_element(0x00280101, "US", little(16, 2));
}

/// Peak of the memory in use [bytes]; it starts again at each call of forget_peak.
std::size_t peak_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;)
    if (std::size_t kilobytes = 0; word == "VmHWM:" && status >> kilobytes) return kilobytes * 1024;
  return 0;
}
bool forget_peak() {
  std::ofstream refs("/proc/self/clear_refs");
  return bool(refs << 5 << std::flush);
}

constexpr std::size_t kZeros = std::size_t{512} << 20, kLittle = std::size_t{32} << 20;  // bytes

// Pixels far longer than the image, and a long private value before them, take no memory.
TEST(DicomDeflated, LongDataTakesNoMemory) {
  const std::string pixels = long_header(0x7fe00010, "OW", 512) + std::string(512, '\1');
  for (const fs::path& file :
       {deflated_file(small_image() + long_header(0x7fe00010, "OW", std::uint32_t(kZeros)), kZeros, ""),
        deflated_file(long_header(0x00091010, "OB", std::uint32_t(kZeros)), kZeros,
                      small_image() + pixels)}) {
    ASSERT_LT(fs::file_size(file), kZeros / 100);
    if (!forget_peak()) GTEST_SKIP() << "the system cannot measure a peak of memory";
    const std::size_t before = peak_memory();
    const io::DicomFile header = io::read_dicom_header(file);
    (void)read_ct(Exec(1), file);  // one slice is no volume
    EXPECT_LT(peak_memory(), before + kLittle);
    ASSERT_TRUE(header.slice) << header.problem;
    EXPECT_EQ(header.slice->columns, 16);
  }
}

// The pixels behind a long private value are those of the file.
TEST(DicomDeflated, PixelsAfterLongValueAreRead) {
  std::string samples;
  for (int n = 0; n < 256; n++) samples += little(std::uint64_t(n), 2);
  const std::size_t length = 3'000'001;
  const fs::path file = deflated_file(long_header(0x00091010, "OB", std::uint32_t(length)), length,
                                      small_image() + long_header(0x7fe00010, "OW", 512) + samples);
  const io::DicomFile header = io::read_dicom_header(file);
  ASSERT_TRUE(header.slice) << header.problem;
  io::InflatedStream inflated(io::deflated_dataset(file, header.slice->dataset_offset));
  std::vector<std::int16_t> hu(256);
  const auto read = io::read_plain_samples(*header.slice, &inflated, hu);
  ASSERT_TRUE(read) << read.error().message;
  for (int n = 0; n < 256; n++) ASSERT_EQ(hu[std::size_t(n)], n);
}

// A header of many short values is refused before they fill the memory.
TEST(DicomDeflated, RejectsEndlessHeader) {
  std::string values;
  for (std::uint32_t n = 0; n < 40000; n++) {
    const std::uint32_t tag = (0x0009u + 2 * (n >> 12)) << 16 | (0x1000u + (n & 0xfff));
    values += long_header(tag, "UT", 4000) + std::string(4000, ' ');
  }
  const fs::path file = deflated_file(values + small_image(), 0, "");
  const io::DicomFile header = io::read_dicom_header(file);
  EXPECT_FALSE(header.slice);
  EXPECT_NE(header.problem.find("the header is too large for an image"), std::string::npos) << header.problem;
}

// A stream that ends early or is damaged gives fewer bytes and is not whole.
TEST(DicomDeflated, StreamReadsForward) {
  const fs::path file = test::fresh_folder() / "raw";
  const std::string packed = raw_deflated("abc", 1'000'000, "xyz");
  test::write(file, packed);
  io::InflatedStream whole({file, 0, std::int64_t(packed.size())});
  char three[3] = {};
  EXPECT_EQ(whole.read(1'000'003, three), 3u);
  EXPECT_EQ(std::string(three, 3), "xyz");
  EXPECT_EQ(whole.read(1'000'006, three), 0u);
  EXPECT_TRUE(whole.is_whole());
  EXPECT_EQ(whole.read(0, three), 0u) << "it never goes back";
  io::InflatedStream cut({file, 0, std::int64_t(packed.size()) / 2});
  EXPECT_EQ(cut.read(1'000'003, three), 0u);
  EXPECT_FALSE(cut.is_whole());
}

}  // namespace
}  // namespace turgor

// Handwritten NRRD and MetaImage files with known samples and grids.
#include <cstring>
#include <numeric>

#include <sys/stat.h>

#include "tests/folders.hpp"
#include "tests/refused.hpp"
#include "turgor/io/files/deflate.hpp"
#include "turgor/io/volume/volume_file.hpp"

namespace turgor::io {
namespace {

namespace fs = std::filesystem;
using test::fresh_folder;
using test::write;

/// 2 x 3 x 2 samples that count from 1000, with `components` values each.
std::vector<std::int16_t> numbers(std::size_t components = 1) {
  std::vector<std::int16_t> all(12 * components);
  std::iota(all.begin(), all.end(), std::int16_t(1000));
  return all;
}

/// Two bytes per sample: high byte last (little endian) or first.
std::string stored(const std::vector<std::int16_t>& samples, bool is_big = false) {
  std::string all;
  for (const std::int16_t sample : samples) {
    const char low = char(sample & 255), high = char(sample >> 8);
    all += is_big ? high : low;
    all += is_big ? low : high;
  }
  return all;
}

std::string packed(std::string_view bytes, Deflate format = Deflate::kGzip) {
  std::string all;
  deflate({bytes}, format, [&all](std::string_view chunk) { all += chunk; });
  return all;
}

std::vector<std::int16_t> samples_of(const Result<RawVolume>& raw) {
  EXPECT_TRUE(raw) << (raw ? "" : raw.error().message);
  if (!raw || raw->type != SampleType::kInt16) return {};
  const auto* first = reinterpret_cast<const std::int16_t*>(raw->bytes.data());
  return {first, first + raw->value_count()};
}

const std::string kDirections = "(0.5,0,0) (0,2,0) (0,0,3)";

std::string nrrd(const std::string& more, const std::string& sizes = "2 3 2",
                 const std::string& directions = kDirections) {
  return "NRRD0004\ntype: short\ndimension: " + std::string(sizes.size() > 5 ? "4" : "3") +
         "\nspace: left-posterior-superior\nsizes: " + sizes + "\nspace directions: " + directions +
         "\nspace origin: (10,20,30)\n" + more + "\n";
}
const std::string kRaw = "endian: little\nencoding: raw\n", kGzip = "endian: little\nencoding: gzip\n";

std::string meta(const std::string& more, const std::string& data_file = "LOCAL") {
  return "ObjectType = Image\nNDims = 3\nBinaryData = True\nElementSpacing = 0.5 2 3\nOffset = 10 20 30\n"
         "DimSize = 2 3 2\nElementType = MET_SHORT\n" +
         more + "ElementDataFile = " + data_file + "\n";
}

class VolumeSamples : public ::testing::Test {
 protected:
  Result<RawVolume> read(const std::string& name, const std::string& content) {
    write(folder / name, content);
    return read_volume_file(folder / name);
  }
  fs::path folder = fresh_folder();
  std::string bytes = stored(numbers()), big = stored(numbers(), true);
};

// NRRD samples are read in both byte orders, raw and compressed.
TEST_F(VolumeSamples, NrrdRawAndCompressed) {
  const std::string end = "endian: big\nencoding: ";
  EXPECT_EQ(samples_of(read("a.nrrd", nrrd(kRaw) + bytes)), numbers());
  EXPECT_EQ(samples_of(read("a.nrrd", nrrd(end + "raw\n") + big)), numbers());
  EXPECT_EQ(samples_of(read("a.nrrd", nrrd(kGzip) + packed(bytes))), numbers());
  EXPECT_EQ(samples_of(read("a.nrrd", nrrd(end + "gz\n") + packed(big))), numbers());
}

// MetaImage samples are read in both byte orders, raw and compressed.
TEST_F(VolumeSamples, MetaImageRawAndCompressed) {
  const std::string zlib = packed(bytes, Deflate::kZlib), zlib_big = packed(big, Deflate::kZlib);
  const std::string is_packed = "CompressedData = True\n";
  EXPECT_EQ(samples_of(read("a.mha", meta("") + bytes)), numbers());
  EXPECT_EQ(samples_of(read("a.mha", meta("BinaryDataByteOrderMSB = True\n") + big)), numbers());
  EXPECT_EQ(samples_of(read("a.mha", meta("ElementByteOrderMSB = True\n") + big)), numbers());
  EXPECT_EQ(samples_of(read("a.mha", meta(is_packed) + zlib)), numbers());
  EXPECT_EQ(samples_of(read("a.mha", meta(is_packed + "BinaryDataByteOrderMSB = True\n") + zlib_big)),
            numbers());
  const std::string size = "CompressedDataSize = " + std::to_string(zlib.size()) + "\n";
  EXPECT_EQ(samples_of(read("a.mha", meta(is_packed + size) + zlib + "more")), numbers());
}

// Samples are read from a separate file if the header names one.
TEST_F(VolumeSamples, DetachedDataFile) {
  write(folder / "my ct.raw", bytes);
  write(folder / "ct.raw.gz", packed(bytes));
  write(folder / "ct.zraw", packed(bytes, Deflate::kZlib));
  EXPECT_EQ(samples_of(read("a.nhdr", nrrd(kRaw + "data file: my ct.raw\n"))), numbers());
  EXPECT_EQ(samples_of(read("a.nhdr", nrrd(kGzip + "datafile: ./ct.raw.gz\n"))), numbers());
  EXPECT_EQ(samples_of(read("a.mhd", meta("", "my ct.raw"))), numbers());
  EXPECT_EQ(samples_of(read("a.mhd", meta("CompressedData = True\n", "ct.zraw"))), numbers());
}

// Bytes and lines that the header skips precede the samples; impossible skips are rejected.
TEST_F(VolumeSamples, ByteAndLineSkip) {
  write(folder / "h.raw", "head" + bytes);
  EXPECT_EQ(samples_of(read("a.nrrd", nrrd(kRaw + "byte skip: 4\n") + "head" + bytes)), numbers());
  EXPECT_EQ(samples_of(read("a.nrrd", nrrd(kRaw + "byte skip: -1\n") + "whatever" + bytes)), numbers());
  EXPECT_EQ(samples_of(read("a.nrrd", nrrd(kRaw + "line skip: 2\nbyte skip: 1\n") + "a\nb\n:" + bytes)),
            numbers());
  EXPECT_EQ(samples_of(read("a.nrrd", nrrd(kGzip + "line skip: 1\nbyte skip: 4\n") + "a line\n" +
                                          packed("head" + bytes))),
            numbers());
  EXPECT_EQ(samples_of(read("a.mhd", meta("HeaderSize = 4\n", "h.raw"))), numbers());
  EXPECT_EQ(samples_of(read("a.mhd", meta("HeaderSize = -1\n", "h.raw"))), numbers());
  EXPECT_REFUSED(read("a.nrrd", nrrd(kRaw + "byte skip: 4\n") + bytes), "24 bytes", "holds 20");
  EXPECT_REFUSED(read("a.nrrd", nrrd(kRaw + "byte skip: 999\n") + bytes), "holds 0");
  EXPECT_REFUSED(read("a.nrrd", nrrd(kRaw + "byte skip: -2\n") + bytes), "byte skip: -2", "-1 or more");
  EXPECT_REFUSED(read("a.nrrd", nrrd(kRaw + "byte skip: 9223372036854775807\n") + bytes), "byte skip");
  EXPECT_REFUSED(read("a.nrrd", nrrd(kRaw + "line skip: 99\n") + bytes), "99 lines", "fewer");
  EXPECT_REFUSED(read("a.nrrd", nrrd(kGzip + "byte skip: -1\n") + packed(bytes)), "byte skip: -1");
  EXPECT_REFUSED(read("a.mhd", meta("HeaderSize = 99\n", "h.raw")), "holds 0");
  EXPECT_REFUSED(read("a.mha", meta("HeaderSize = 9\n") + bytes), "HeaderSize = 9");
}

// A compressed stream that is damaged, too short or too long is rejected.
TEST_F(VolumeSamples, CompressedStreamHasExactSize) {
  const auto refused = [&](const std::string& stream, const char* found) {
    EXPECT_REFUSED(read("a.nrrd", nrrd(kGzip) + stream), "24 bytes of samples (2 x 3 x 2)", found);
    EXPECT_REFUSED(read("a.mha", meta("CompressedData = True\n") + stream), "24 bytes", found);
  };
  std::string checksum = packed(bytes);
  checksum[checksum.size() - 6] ^= 1;
  refused(packed(bytes.substr(2)), "holds 22");
  refused(packed(bytes + "x"), "more than that");
  refused(packed(bytes).substr(0, packed(bytes).size() - 5), "holds 24");  // truncated within the checksum
  refused(checksum, "damaged");
  refused("no stream at all, but some bytes", "damaged");
  refused("", "0 compressed");
}

// Samples may be stored as several concatenated gzip streams.
TEST_F(VolumeSamples, ConcatenatedGzipStreams) {
  const std::string streams = packed(bytes.substr(0, 7)) + packed(bytes.substr(7)) + packed("");
  EXPECT_EQ(samples_of(read("a.nrrd", nrrd(kGzip) + streams)), numbers());
  EXPECT_EQ(samples_of(read("a.nrrd", nrrd(kGzip) + packed(bytes) + "what follows")), numbers());
  EXPECT_REFUSED(read("a.nrrd", nrrd(kGzip) + streams + packed("x")), "more than that");
}

// Inflating skips a prefix longer than many blocks and checks the exact length.
TEST_F(VolumeSamples, InflateSkipsManyBlocks) {
  std::string noise(3'000'000,
                    '\0');  // incompressible: a dozen input blocks; the skip spans several output blocks
  std::uint32_t state = 1;
  for (char& byte : noise) byte = char((state = state * 1664525 + 1013904223) >> 24);
  const std::string stream = packed(noise);
  write(folder / "noise.gz", "head" + stream);
  const FileRange range{folder / "noise.gz", 4, std::int64_t(4 + stream.size())};
  std::vector<std::byte> out(2'000'000);
  const Inflated inflated = inflate(range, 1'000'000, out);
  EXPECT_EQ(inflated.end, Inflated::End::kExact);
  EXPECT_EQ(std::memcmp(out.data(), noise.data() + 1'000'000, out.size()), 0);
  EXPECT_EQ(inflate(range, 999'999, out).end, Inflated::End::kTooLong);
  EXPECT_EQ(inflate(range, 1'000'001, out).end, Inflated::End::kTooShort);
  EXPECT_EQ(inflate(range, 1'000'001, out).count, out.size() - 1);
}

// Vector components are interleaved in memory, whichever axis holds them in the file.
TEST_F(VolumeSamples, ComponentsAreInterleaved) {
  const std::vector<std::int16_t> mixed = numbers(3);
  std::vector<std::int16_t> planes,
      rows;  // planes: all first components, then all second …; rows: the same within each row of i
  for (std::size_t c = 0; c < 3; c++)
    for (std::size_t v = 0; v < 12; v++) planes.push_back(mixed[3 * v + c]);
  for (std::size_t row = 0; row < 6; row++)
    for (std::size_t c = 0; c < 3; c++)
      for (std::size_t i = 0; i < 2; i++) rows.push_back(mixed[3 * (2 * row + i) + c]);
  const auto vectors = [&](const char* sizes, const std::string& directions, const char* kinds,
                           const std::vector<std::int16_t>& in_file) {
    const auto raw =
        read("a.nrrd", nrrd(kRaw + "kinds: " + kinds + "\n", sizes, directions) + stored(in_file));
    EXPECT_EQ(samples_of(raw), mixed) << sizes << kinds;
    ASSERT_TRUE(raw);
    EXPECT_EQ(raw->components, 3);
    EXPECT_EQ(raw->grid.size, (Int3{2, 3, 2}));
  };
  vectors("3 2 3 2", "none " + kDirections, "vector domain domain domain", mixed);
  vectors("2 3 3 2", "(0.5,0,0) none (0,2,0) (0,0,3)", "space list space space", rows);
  vectors("2 3 2 3", kDirections + " none", "domain domain domain 3-vector", planes);
  const auto meta_image = read("a.mha", meta("ElementNumberOfChannels = 3\n") + stored(mixed));
  EXPECT_EQ(samples_of(meta_image), mixed);
}

// A fourth axis of time, or of unknown kind, is not read as vector components.
TEST_F(VolumeSamples, RejectsTimeSeries) {
  const std::string three = stored(numbers(3));
  for (const char* kinds : {"", "kinds: domain domain domain time\n", "kinds: domain domain domain ???\n"})
    EXPECT_REFUSED(read("a.nrrd", nrrd(kRaw + kinds, "2 3 2 3", kDirections + " none") + three), "kinds",
                   "vector");
  EXPECT_EQ(samples_of(read("a.nrrd", nrrd(kRaw, "2 3 2 1", kDirections + " none") + bytes)), numbers());
  EXPECT_REFUSED(read("a.nrrd", nrrd(kRaw + "kinds: vector domain domain\n") + bytes), "kinds");
}

// Samples of every type are read back exactly from every format.
TEST_F(VolumeSamples, SampleTypesRoundTrip) {
  const Grid grid{.size = {5, 4, 3},
                  .spacing = {1e-3, 2e-3, 3e-3},
                  .origin = {},
                  .axes = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
  std::vector<unsigned char> any(60 * 3 * 8);
  for (std::size_t n = 0; n < any.size(); n++) any[n] = static_cast<unsigned char>(n * 37 + n / 7);
  for (int type = 0; type <= int(SampleType::kDouble); type++)
    for (const int components : {1, 3})
      for (const char* name : {"a.nii", "a.nii.gz", "a.nrrd", "a.mha"}) {
        ASSERT_TRUE(write_volume_file(folder / name, {grid, SampleType(type), components, any.data()}));
        const auto raw = read_volume_file(folder / name);
        ASSERT_TRUE(raw) << raw.error().message;
        EXPECT_EQ(raw->type, SampleType(type));
        ASSERT_EQ(raw->bytes.size(), 60 * std::size_t(components) * byte_size(SampleType(type)));
        EXPECT_EQ(std::memcmp(raw->bytes.data(), any.data(), raw->bytes.size()), 0) << name << " " << type;
      }
}

// Unsupported encodings, file lists, versions and fields give an error message.
TEST_F(VolumeSamples, RejectsUnsupportedFeatures) {
  for (const char* encoding : {"bzip2", "bz2", "hex", "ascii", "text", "txt", "zrl"})
    EXPECT_REFUSED(read("a.nrrd", nrrd("endian: little\nencoding: " + std::string(encoding) + "\n") + bytes),
                   encoding, "expected raw or gzip");
  EXPECT_REFUSED(read("a.nrrd", nrrd("encoding: raw\n") + bytes), "endian", "little or big");
  EXPECT_REFUSED(read("a.nhdr", nrrd(kRaw + "data file: LIST\n")), "LIST", "one file");
  EXPECT_REFUSED(read("a.nhdr", nrrd(kRaw + "data file: a%d.raw 1 2 1\n")), "a%d.raw", "one file");
  EXPECT_REFUSED(read("a.mhd", meta("", "LIST")), "LIST", "one file");
  EXPECT_REFUSED(read("a.mhd", meta("", "a%d.raw 1 2 1")), "a%d.raw", "one file");
  EXPECT_REFUSED(read("a.nrrd", "NRRD0009\n" + nrrd(kRaw).substr(9) + bytes), "NRRD0009");
  EXPECT_REFUSED(read("a.nrrd", nrrd(kRaw + "spacing: 1 1 1\n") + bytes), "unknown NRRD field \"spacing\"");
  EXPECT_REFUSED(read("a.mha", meta("ElementToIntensityFunctionSlope = 0\n") + bytes), "Slope = 0");
}

// A data file that is a pipe, a device or missing is rejected without blocking.
TEST_F(VolumeSamples, RejectsPipeAsDataFile) {
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
  EXPECT_REFUSED(read("a.nhdr", nrrd(kRaw + "data file: pipe\n")), "a.nhdr", "pipe: is a pipe");
  EXPECT_REFUSED(read("a.mhd", meta("", "pipe")), "a.mhd", "pipe: is a pipe");
  EXPECT_REFUSED(read("a.mhd", meta("", "/dev/zero")), "is a device");
  EXPECT_REFUSED(read("a.mhd", meta("", "none.raw")), "none.raw", "does not exist");
}

// Slope and offset of a MetaImage are read.
TEST_F(VolumeSamples, MetaImageHasSlopeAndOffset) {
  const auto raw = read("a.mha", meta("ElementToIntensityFunctionSlope = 2\n"
                                      "ElementToIntensityFunctionOffset = -1024\n") +
                                     bytes);
  EXPECT_EQ(samples_of(raw), numbers());
  EXPECT_EQ(raw->slope, 2);
  EXPECT_EQ(raw->intercept, -1024);
}

}  // namespace
}  // namespace turgor::io

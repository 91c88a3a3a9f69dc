// A DICOM series in its own folder, and functions that modify its files.
#pragma once

#include <algorithm>
#include <cmath>

#include "tests/folders.hpp"
#include "tests/refused.hpp"
#include "turgor/io/ct.hpp"
#include "turgor/io/dicom/dicom.hpp"

namespace turgor::test {

namespace fs = std::filesystem;

inline CtVolume make_ct(int slices = 6) {
  const Vec3d i = normalized(Vec3d{1, 0.1, 0.05}), k = normalized(cross(i, Vec3d{-0.1, 1, 0.02}));
  CtVolume ct{{.size = {9, 7, slices},
               .spacing = {0.75e-3, 0.5e-3, 1.25e-3},
               .origin = {0.1, -0.2, 0.3},
               .axes = {{i, cross(k, i), k}}},
              {}};
  for (std::size_t n = 0; n < sample_count(ct.grid); n++)
    ct.samples.push_back(std::int16_t(int(n * 7919 % 5000) - 2000));
  return ct;
}

/// Replaces the value and the length of an element in an explicit little-endian file.
inline void set_value(const fs::path& file, std::uint16_t group, std::uint16_t element, std::string value) {
  std::string bytes = bytes_of(file);
  const std::string tag{char(group & 255), char(group >> 8), char(element & 255), char(element >> 8)};
  const std::size_t at = bytes.find(tag, 132);
  ASSERT_NE(at, std::string::npos);
  const std::size_t length =
      std::size_t((unsigned char)bytes[at + 6]) + 256 * std::size_t((unsigned char)bytes[at + 7]);
  if (value.size() % 2) value += ' ';
  bytes.replace(at + 8, length, value);
  bytes[at + 6] = char(value.size() & 255);
  bytes[at + 7] = char(value.size() >> 8);
  write(file, bytes);
}

struct Series {
  const std::filesystem::path folder = fresh_folder();
  CtVolume ct;
  fs::path path = folder / "ct";

  explicit Series(int slices = 6) : ct(make_ct(slices)) {
    const Status written = write_dicom(Exec(2), path, ct, patient_alone("Test^Patient"));
    EXPECT_TRUE(written) << written.error().message;
  }
  fs::path slice(int number) const { return path / ("slice-0000" + std::to_string(number) + ".dcm"); }
  void set_every(std::uint16_t group, std::uint16_t element, const std::string& value) const {
    for (const auto& entry : fs::directory_iterator(path)) set_value(entry.path(), group, element, value);
  }
  Result<CtFile> read(const std::string& series = "") const { return read_ct(Exec(2), path, {series, {}}); }
};

}  // namespace turgor::test

// Locations of the elements of a DICOM file, checked so that every length stays within the file. GDCM's
// parser aborts on corrupt files, so GDCM is used only to decode compressed pixels. Internal to io/.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/core/result.hpp"
#include "turgor/io/files/deflate.hpp"

namespace turgor::io {

/// A fragment of compressed pixels in the file.
struct DicomFragment {
  std::uint64_t offset = 0, length = 0;  // [bytes]
};

using DicomValues = std::map<std::uint32_t, std::string>;  // group · 65536 + element → value

struct DicomElements {
  DicomValues values;  // top level, before the pixels, short ones
  // Enhanced images and segmentations: values that all frames share, values by frame, values by segment, each
  // with nested sequences. [PS3.3, C.7.6.16, C.8.20]
  std::vector<DicomValues> shared, frames, segments;
  std::string transfer_syntax;       // empty: missing
  std::string media_class;           // (0002,0002), SOP class of the file; empty: missing
  bool has_magic = false;            // "DICM" after the preamble
  bool is_big_endian = false;        // numbers and pixels
  bool is_deflated = false;          // all data after the meta information
  bool is_encapsulated = false;      // pixels are compressed fragments
  std::uint64_t dataset_offset = 0;  // after the meta information, in the file
  std::uint64_t pixel_offset = 0,
                pixel_length =
                    0;  // in the file or its inflated data; of all fragments together if encapsulated
  std::vector<DicomFragment> fragments;  // of compressed pixels

  bool has(std::uint16_t group, std::uint16_t element) const {
    return values.contains(std::uint32_t(group) << 16 | element);
  }
  std::string_view value(std::uint16_t group, std::uint16_t element) const {
    const auto found = values.find(std::uint32_t(group) << 16 | element);
    return found == values.end() ? std::string_view{} : std::string_view(found->second);
  }
};

/// View of a file that is read on demand: elements are skipped by their length, so that little of a large
/// file is read. It may also view the inflated data of a file, of which it holds one window.
class FileWindow {
 public:
  explicit FileWindow(const std::filesystem::path& file);
  FileWindow(const FileRange& deflated, std::uint64_t inflated_size);
  const std::filesystem::path& file() const { return file_; }
  std::uint64_t size() const { return size_; }
  /// Empty if the file ends before. Valid until the next call.
  std::string_view view(std::uint64_t at, std::size_t length);

 private:
  void load(std::uint64_t at, std::size_t count);
  void load_inflated(std::uint64_t at, std::size_t count);

  std::filesystem::path file_;
  std::ifstream stream_;
  FileRange deflated_;                      // only of inflated data
  std::optional<InflatedStream> inflated_;  // has been read up to the end of the window
  std::uint64_t size_ = 0, start_ = 0;
  std::string bytes_;
};

/// Elements before the first error stay in `found`. The error gives the reason and the offset; it names no
/// file.
Status find_elements(FileWindow& file, DicomElements& found);
/// Deflated data set of a file: its range, from the end of the meta information on.
FileRange deflated_dataset(const std::filesystem::path& file, std::uint64_t dataset_offset);

}  // namespace turgor::io

// Where the elements of a DICOM file lie, checked: every length stays within the file. GDCM's parser
// aborts the program on corrupt files; it decodes compressed pixels, and those alone are handed to it.
// Internal to io/.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "turgor/core/result.hpp"

namespace turgor::io {

/// A piece of compressed pixels in the file.
struct DicomFragment {
  std::uint64_t offset = 0, length = 0;  // [bytes]
};

struct DicomElements {
  std::map<std::uint32_t, std::string_view>
      values;                    // group · 65536 + element → value; top level, up to the pixels
  std::string transfer_syntax;   // empty: not said
  bool is_encapsulated = false;  // pixels are compressed fragments
  std::uint64_t pixel_offset = 0, pixel_length = 0;  // in the file; of all fragments together if encapsulated
  std::vector<DicomFragment> fragments;              // of compressed pixels

  std::string_view value(std::uint16_t group, std::uint16_t element) const {
    const auto found = values.find(std::uint32_t(group) << 16 | element);
    return found == values.end() ? std::string_view{} : found->second;
  }
};

/// `bytes` are the whole file, or its first part when all elements before the pixels lie in it; `file_size`
/// is that of the whole file. Values point into `bytes`. The error says what is wrong and where; it names no
/// file.
Result<DicomElements> find_elements(std::string_view bytes, std::uint64_t file_size);

}  // namespace turgor::io

#include "turgor/io/mesh/mesh_frame.hpp"

namespace turgor::io {

void note_frame(std::string_view bytes, std::string_view field, std::vector<std::string>& notes) {
  constexpr std::size_t kHead = 4096;  // bytes
  const bool is_ras = field.empty() ? bytes.substr(0, kHead).find("SPACE=RAS") != bytes.npos : field == "RAS";
  if (!is_ras) return;
  notes.push_back(
      "the file declares RAS, but bodies are in LPS; its coordinates were used unchanged, with the signs of "
      "x "
      "and y of RAS");
}

}  // namespace turgor::io

// What loading a body may use, whatever its model is.
#pragma once

#include <functional>
#include <string>

#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"

namespace turgor {

/// Called before work that takes long: a word for a progress bar, and a sentence that says what it will take
/// (may be empty). Returns what is told the finished fraction; both may be empty.
using BeginWork = std::function<Progress(const std::string& label, const std::string& sentence)>;

inline Progress begin_work(const BeginWork& begin, const std::string& label,
                           const std::string& sentence = "") {
  return begin ? begin(label, sentence) : Progress();
}

/// What a world is made for. To draw a recording, bodies whose surface it holds stay empty.
enum class Purpose : std::uint8_t { kSimulate, kDraw };

struct Loading {
  const Exec& exec;
  const BeginWork& begin;
  Purpose purpose = Purpose::kSimulate;
};

}  // namespace turgor

// Parameters of loading, common to all models.
#pragma once

#include <functional>
#include <string>

#include "turgor/core/exec.hpp"
#include "turgor/core/progress.hpp"

namespace turgor {

/// Called before a long task: label of a progress bar, and a sentence about expected cost (may be empty). The
/// returned callback receives the finished fraction; both may be empty.
using BeginWork = std::function<Progress(const std::string& label, const std::string& sentence)>;

inline Progress begin_work(const BeginWork& begin, const std::string& label,
                           const std::string& sentence = "") {
  return begin ? begin(label, sentence) : Progress();
}

/// Purpose of a world. For drawing a recording, bodies whose surface it contains stay empty.
enum class Purpose : std::uint8_t { kSimulate, kDraw };

struct Loading {
  const Exec& exec;
  const BeginWork& begin;
  Purpose purpose = Purpose::kSimulate;
};

}  // namespace turgor

#include "turgor/core/progress.hpp"

#include <algorithm>
#include <cstdio>

#include <unistd.h>

#include "turgor/core/plain_text.hpp"

namespace turgor {

ProgressBar::ProgressBar(const std::string& label)
    : label_(on_one_line(label)), shown_(isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() {
  if (shown_ && last_tenth_ >= 0) std::fprintf(stderr, "\r\033[K");
}

void ProgressBar::update(double fraction) {
  if (!shown_) return;
  const double seconds = timer_.seconds();
  const int tenth = static_cast<int>(seconds * 10);
  if (last_tenth_.exchange(tenth) == tenth) return;
  constexpr int kWidth = 30;
  fraction = std::clamp(fraction, 0.0, 1.0);
  std::string bar(kWidth, '.');
  std::fill_n(bar.begin(), static_cast<int>(fraction * kWidth), '#');
  const double left = fraction > 0 ? seconds * (1 - fraction) / fraction : 0;
  std::fprintf(stderr, "\r\033[K%s [%s] %3.0f %%  %.0f s left", label_.c_str(), bar.c_str(), 100 * fraction,
               left);
  std::fflush(stderr);
}

}  // namespace turgor

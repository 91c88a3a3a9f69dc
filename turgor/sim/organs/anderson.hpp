// Anderson's mixing of a fixed-point iteration z ← g(z) (D. G. Anderson, J. ACM 12, 1965). With the residuals
// f = g(z) − z, the next argument is the combination of earlier images whose linearized residual is smallest.
#pragma once

#include <span>
#include <vector>

namespace turgor {

class AndersonMixing {
 public:
  /// Replaces the argument z by the next one. `image` is g(z).
  void advance(std::span<const double> image, std::span<double> z);

 private:
  struct Change {
    std::vector<double> residual, image;
  };
  Change last_;                  // residual and image of the latest argument
  std::vector<Change> changes_;  // between successive arguments, newest first
};

}  // namespace turgor

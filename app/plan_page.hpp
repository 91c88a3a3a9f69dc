// Results of `turgor plan-excision`: verdict, polar plot and page.
#pragma once

#include <string>
#include <vector>

namespace turgor {

/// An excision of one shape in one direction, after its closure.
struct PlannedExcision {
  double length = 0, width = 0;               // of the lens [m]
  double angle = 0;                           // of the length, from the direction of the scene [degrees]
  double angle_to_lines = 0;                  // of the length, 0…90 [degrees]
  bool is_directional = false;                // the skin is tenser along Langer's lines
  double closing_force = 0, tension_max = 0;  // [N]
  double gape = 0, dog_ear = 0;               // [m]
  double stretch = 0;                         // of the most stretched disc of skin, relative to the CT [1]
  double shrinkage = 0;                       // of the specimen's length, relative
  int lost = 0;                               // stitches that tore out or broke
  bool is_closed = false;                     // the lips meet, and the stitches came to rest
  std::string problem;                        // reason for which it could not be simulated; empty = none

  double ratio() const { return length / width; }
};

/// Best and worst excision by closing force.
struct PlanVerdict {
  std::size_t best = 0, worst = 0;
  double ratio = 0;         // of the largest closing force to the least
  bool has_closed = false;  // a wound closes in some direction; otherwise none is best or worst
  std::string sentence;
};
PlanVerdict verdict_of(const std::vector<PlannedExcision>& found);

/// Closing force over direction as a closed curve around a center for each shape, an <svg> element. Excisions
/// of one shape follow each other.
std::string polar_svg(const std::vector<PlannedExcision>& found, const PlanVerdict& verdict);
/// Page with verdict, plot and table.
std::string plan_page(const std::string& name, const std::vector<PlannedExcision>& found,
                      const PlanVerdict& verdict);

}  // namespace turgor

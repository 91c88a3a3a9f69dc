// The parts of a report that are tables of quantities: what report.html and the terminal show of report.json.
#pragma once

#include <vector>

#include "turgor/sim/report/quantity.hpp"

namespace turgor {

struct Section {
  const char* heading;                // of its table on the page
  const char* item;                   // "wound": what a column of the table is
  Json (*items)(const Json& report);  // empty when the report has none
  std::vector<Caption> captions;
};

/// What a report has under a key, which need not be there.
inline Json items_of(const Json& report, const char* key) { return report.value(key, Json::array()); }

/// Each where its quantities are.
Section wound_section();  // report_lattice.cpp
Section lattice_section();
Section deformed_section();
Section tool_section();  // report_touch.cpp
Section sfem_section();
Section cost_section();      // report_compare.cpp
Section rhombus_section();   // report_rhombus.cpp
Section obstacle_section();  // report_cloth.cpp
Section hold_section();
Section cloth_section();
Section haptics_section();  // sim/live/report_haptics.cpp
Section timing_section();   // report.cpp

/// All of them, in the order of a report.
const std::vector<Section>& report_sections();

}  // namespace turgor

// Sections of a report: tables of quantities in report.html and in the terminal.
#pragma once

#include <vector>

#include "turgor/sim/report/quantity.hpp"

namespace turgor {

struct Section {
  const char* heading;                // title of its table
  const char* item;                   // kind of a column, such as "wound"
  Json (*items)(const Json& report);  // empty if the report has none
  std::vector<Caption> captions;
  bool item_per_row = false;  // a row per item, for items that are mostly text
  bool is_result = false;     // shown first, beside the parameters
};

/// Value of a report's key; an empty array if it is missing.
inline Json items_of(const Json& report, const char* key) { return report.value(key, Json::array()); }

/// Each is defined next to its quantities.
Section wound_section();   // report_lattice.cpp
Section suture_section();  // report_suture.cpp
Section skin_section();    // report_skin.cpp
Section lattice_section();
Section deformed_section();
Section tool_section();  // report_touch.cpp
Section sfem_section();
Section attachment_section();  // report_organs.cpp
Section body_contact_section();
Section cost_section();      // report_compare.cpp
Section rhombus_section();   // report_rhombus.cpp
Section rigid_section();     // report_rigid.cpp
Section obstacle_section();  // report_cloth.cpp
Section hold_section();
Section cloth_section();
Section texture_section();  // report_texture.cpp
Section haptics_section();  // sim/live/report_haptics.cpp
Section tissue_section();   // report.cpp
Section timing_section();

/// All sections, in the order of a report.
const std::vector<Section>& report_sections();

}  // namespace turgor

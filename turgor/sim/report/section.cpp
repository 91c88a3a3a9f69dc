#include "turgor/sim/report/section.hpp"

namespace turgor {

const std::vector<Section>& report_sections() {
  static const std::vector<Section> kSections{
      wound_section(),   suture_section(),     skin_section(),         deformed_section(), lattice_section(),
      tool_section(),    attachment_section(), body_contact_section(), cost_section(),     sfem_section(),
      rhombus_section(), rigid_section(),      obstacle_section(),     hold_section(),     cloth_section(),
      texture_section(), haptics_section(),    tissue_section(),       timing_section()};
  return kSections;
}

}  // namespace turgor

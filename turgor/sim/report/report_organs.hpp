// Part of the report about attachments of bodies and contact between bodies.
#pragma once

#include <string>
#include <vector>

#include "turgor/sim/report/report.hpp"

namespace turgor {

/// One row for each attachment, and one for each contact of two bodies.
Json attachment_report(const World& world);
Json body_contact_report(const World& world);

/// Warnings about attachments and contacts whose forces are not those of the model.
std::vector<std::string> coupling_warnings(const World& world);

}  // namespace turgor

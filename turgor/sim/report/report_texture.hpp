// Textures of touched surfaces in a report. Used by report.cpp.
#pragma once

#include "turgor/sim/report/report.hpp"

namespace turgor {

/// Texture of a body, and the vibration of its tools; a null value for a smooth body.
Json texture_report(const TextureScene& scene, const SfemBody& body);
Json texture_report(const TextureScene& scene, const RhombusBody& body);
Json texture_report(const TextureScene& scene, const FrameTouchedBody& body);

/// Warnings of bodies whose texture had no ticks.
std::vector<std::string> texture_warnings(const World& world);

}  // namespace turgor

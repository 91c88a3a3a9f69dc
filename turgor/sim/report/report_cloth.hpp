// The part of a report that is about cloth.
#pragma once

#include "turgor/sim/report/report.hpp"

namespace turgor {

Json cloth_report(const Exec& exec, const World& world, const ClothBody& body);
/// What the reader of a report should know before believing it.
std::vector<std::string> cloth_warnings(const World& world);
/// Of all cloths of a world, one after another.
std::uint64_t cloth_hash(const World& world, std::uint64_t seed);

namespace page {
/// Empty when there is no cloth.
std::string cloth_curves(const Json& report);
}  // namespace page

}  // namespace turgor

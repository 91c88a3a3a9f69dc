// Formats numbers and amounts with units.
#pragma once

#include <string>

#include "turgor/sim/report/quantity.hpp"

namespace turgor {

/// Number with three or four digits; text unchanged; "" for other values.
std::string number_of(const Json& value);
/// Number with unit. Times and sizes use a suitable unit: 1330 µs are "1.33 ms".
std::string amount(const Json& value, const Unit& unit);

}  // namespace turgor

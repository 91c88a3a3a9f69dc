// Numbers and amounts as people read them.
#pragma once

#include <string>

#include "turgor/sim/report/quantity.hpp"

namespace turgor {

/// A number with three or four digits; text as it is; "" for anything else.
std::string number_of(const Json& value);
/// With its unit; times and bytes in the unit that suits them: 1330 µs are "1.33 ms".
std::string amount(const Json& value, const Unit& unit);

}  // namespace turgor

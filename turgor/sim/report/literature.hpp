// Published values beside the measures and parameters of a report, each with its source. They are ranges to
// compare with, not bounds: most quantities of a report have none.
#pragma once

#include <string>
#include <string_view>

namespace turgor {

/// "-17.0 (people, 111 excisions; doi 10.1111/cup.12401)" for a key of an item such as "wound", in the unit
/// of the key; empty if no value is known.
std::string published_measure(std::string_view item, std::string_view key);
/// The same for a key of a scene, such as "body.torso.skin.tension", in the key's unit.
std::string published_parameter(std::string_view key);

}  // namespace turgor

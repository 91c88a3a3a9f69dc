// The key `up` of meshes that a scene reads from files: cloth, organs, surfaces.
#pragma once

#include "turgor/geometry/up_axis.hpp"
#include "turgor/sim/scene/scene_table.hpp"

namespace turgor {

inline void read_up(SceneTable& table, std::string_view key, UpAxis& up) {
  table.read_choice<UpAxis>(key, up, {{"x", UpAxis::kX}, {"y", UpAxis::kY}, {"z", UpAxis::kZ}},
                            "the axis of the file that points to the head, which becomes +z. `\"y\"`, as in "
                            "modeling programs: (x, y, z) becomes (x, -z, y); `\"x\"`: (-z, y, x)");
}

}  // namespace turgor

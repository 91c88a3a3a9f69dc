// A block of finite elements that tools touch.
#pragma once

#include <utility>

#include <gtest/gtest.h>

#include "turgor/geometry/hex_block.hpp"
#include "turgor/models/sfem/sfem.hpp"

namespace turgor::contact {

/// 60 × 40 × 20 mm of soft tissue on a fixed floor; its top is z = 0.
inline const sfem::Model& soft_block() {
  static const sfem::Model model = [] {
    sfem::Body body;
    body.mesh = hex_block({60e-3, 40e-3, 20e-3}, {12, 8, 4});
    for (Vec3d& x : body.mesh.vertices) x += Vec3d{-30e-3, -20e-3, -20e-3};
    for (const Vec3d x : body.mesh.vertices) body.fixed.push_back(x.z < -19.9e-3);
    body.materials = {{5e3, 0.4}};
    sfem::Model made = *sfem::build(Exec(2), std::move(body), {.touch_depth = 0.02});
    EXPECT_TRUE(sfem::compute_green(Exec(2), made, std::size_t(1) << 30));
    return made;
  }();
  return model;
}

}  // namespace turgor::contact

// [suture.NAME] of a scene: stitches that close a wound.
#pragma once

#include <string>
#include <vector>

#include "turgor/models/lattice/suture/closure.hpp"

namespace turgor {

struct SutureScene {
  std::string name, source_location;
  int incision = 0;  // or excision of the wound: index into Scene::incisions
  int body = 0;      // index into Scene::lattice_bodies
  double spacing = 0.008, bite = 0.005, depth = 0.002;  // of a row [m]
  std::vector<Vec3d> through;                           // points of a single stitch, patient frame [m]
  bool is_running = false;                              // one thread makes all stitches
  std::string material = "nylon 3-0";                   // preset of the thread
  lattice::Thread thread;
  double diameter = 0;       // of the thread [m]
  double thread_length = 0;  // of the thread of all stitches; 0 = as long as needed [m]
  double pull_out = 10;      // force on one point at which the tissue tears [N]
  lattice::Pull pull;
};

}  // namespace turgor

// Pictures of meshes, CT volumes and sections without a window: every function of turgor/view that makes an
// Image. Meshes are drawn by OpenGL through EGL (no display, no X server), volumes by a multithreaded ray
// caster. Patient frame LPS, meters.
#pragma once

#include "turgor/view/annotate.hpp"
#include "turgor/view/camera.hpp"
#include "turgor/view/color.hpp"
#include "turgor/view/mesh_view.hpp"
#include "turgor/view/section_view.hpp"
#include "turgor/view/volume_view.hpp"

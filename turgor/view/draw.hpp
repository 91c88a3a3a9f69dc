// Pictures of meshes, CT volumes and sections, without a window: all of turgor/view that makes an Image.
// Meshes are drawn by OpenGL through EGL (no display, no X server), volumes by a threaded ray-caster. Patient
// frame LPS, metres.
#pragma once

#include "turgor/view/annotate.hpp"
#include "turgor/view/camera.hpp"
#include "turgor/view/color.hpp"
#include "turgor/view/mesh_view.hpp"
#include "turgor/view/section_view.hpp"
#include "turgor/view/volume_view.hpp"

// Forces and motions of a tool compared with the limits of a haptic device: whether a scene fits a device.
#pragma once

#include "turgor/sim/tools/touch_log.hpp"

namespace turgor {

struct DeviceUse {
  double force = 0;           // largest [N]
  double stiffness = 0;       // largest stiffness of felt_stiffness [N/m]
  double reach = 0;           // half the longest side of the box around the tool's path [m]
  std::size_t saturated = 0;  // samples whose force exceeds the device's
};

/// Use of a device whose largest force is `force` [N]; 0: unknown.
DeviceUse device_use(const TouchLog& log, double force);

/// Largest rise of the force per distance of the tool, (|F(b)| − |F(a)|) / |x(b) − x(a)|, over pieces of the
/// path of at least a millimeter [N/m]. Shorter pieces would measure the discretization. Drops of the force,
/// as of a puncture, do not count.
double felt_stiffness(const TouchLog& log);

}  // namespace turgor

// Frames of a session. They run by the clock, or one at a time while the session is paused.
#pragma once

#include <chrono>

namespace turgor {

struct SessionThread;

/// Measurement of the achieved pace.
struct PaceMeter {
  std::chrono::steady_clock::time_point frame_begun;
  double frame_period = 0;  // wall time between frames, running mean [s]
};

/// Adds a sample to an exponential running mean with weight 0.1. The first sample initializes the mean.
inline void add_to_mean(double sample, double& mean) { mean += (mean > 0 ? 0.1 : 1.0) * (sample - mean); }

/// True if a world is loaded and not paused.
bool is_playing(const SessionThread& session);
/// Steps one frame and waits until its due time. Does nothing while the session is paused.
void play_frame(SessionThread& session);
/// Permits haptic ticks for one frame of a paused world. Sets DueWork::step to the time at which these ticks
/// are done.
void begin_single_step(SessionThread& session);
/// Steps the frame of a StepRequest once its ticks are done.
void step_if_due(SessionThread& session);
/// Applies the requested pace to the ticks and the clock. The next frame counts as in time. Requires a world.
void set_pace(SessionThread& session);

}  // namespace turgor

// World of the Python module: scene, bodies and measurements, with a guard against concurrent calls. Calls
// that load, copy, save, step or tick release the interpreter lock; short calls hold it.
#pragma once

#include <atomic>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "arrays.hpp"
#include "given.hpp"
#include "turgor/sim/autosave/saved_world.hpp"
#include "turgor/sim/live/by_hand.hpp"
#include "turgor/sim/live/driven_ticks.hpp"
#include "turgor/sim/report/measures.hpp"
#include "turgor/sim/snapshot.hpp"
#include "turgor/sim/world.hpp"
#include "turgor/sim/world_state.hpp"

namespace turgor {

/// Poses by tick and tool: x, y, z [m] and a quaternion w, x, y, z.
using Poses = nb::ndarray<const double, nb::shape<-1, -1, 7>, nb::c_contig, nb::device::cpu>;
using Holds = nb::ndarray<const bool, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;

/// State of a world and of its measurements.
struct PyState {
  std::shared_ptr<const Scene> scene;  // identifies the world
  WorldState state;
  std::optional<DrivenTicks> driven;
  bool was_touched = false;
  Measures measures;
};

class PyWorld {
 public:
  /// Guard that admits one caller at a time. It is taken with the interpreter lock, which may be released
  /// afterwards, since readers of the world hold that lock. Throws while another thread is in a call.
  class Entered {
   public:
    explicit Entered(PyWorld& world);
    ~Entered() { world_.busy_ = false; }
    Entered(const Entered&) = delete;
    Entered& operator=(const Entered&) = delete;

   private:
    PyWorld& world_;
  };

  /// `left_handed`: grids of given volumes that were mirrored, by body. Requires that the interpreter lock is
  /// released.
  PyWorld(Scene scene, std::map<std::string, Grid> left_handed, int threads, bool keeps_forces,
          const BeginWork& begin);
  /// Independent copy with `threads` threads; 0 = as many as `other`.
  PyWorld(PyWorld& other, int threads);

  void step(int frames);
  /// Runs ticks; `forces` receives ticks · tools · 6 numbers: force [N] and torque [N·m] on every tool. The
  /// caller must have released the interpreter lock.
  void tick(std::size_t ticks, const double* poses, const bool* holds, double* forces);
  bool is_driven() const { return driven_.has_value(); }

  /// Ticks on one thread beside frames of step() on another one. A row of poses whose first number is not
  /// finite is that of the tool's path. `forces` receives tools · 6 numbers as tick() does, `used` the poses.
  void begin_touch();
  void touch_tick(const double* poses, const bool* holds, double* forces, double* used);
  void end_touch();
  /// Throws Refused between begin_touch and end_touch.
  void expect_untouched(const char* call) const;

  /// Cuts and stitches between two frames (sim/live/by_hand.hpp); the first two return names.
  std::string cut(const CutByHand& cut);
  std::string stitch(const StitchByHand& stitch);
  void tighten(const std::string& stitch, std::optional<double> tension, double duration);

  PyState state();
  void set_state(const PyState& state);
  /// State in a file, for a world of the same scene (sim/autosave/saved_world.hpp).
  void save(const std::filesystem::path& path);
  void load(const std::filesystem::path& path);

  const Scene& scene() const { return *scene_; }
  const Exec& exec() const { return exec_; }
  /// For readers that hold the interpreter lock, so that no other thread can start a step.
  World& world() const;
  const Measures& measures() const { return world(), measures_; }
  /// Snapshot of the present state.
  WorldSnapshot& snapshot();
  /// Disables caching of the snapshot, since views may write to the bodies.
  void expect_writers() { has_writers_ = true; }
  TouchingTool& tool(const std::string& name) const;
  /// Present command of a tool from its path, also between ticks.
  contact::ToolCommand path_command(std::size_t tool) const;
  /// A volume on the grid of a body's CT, with the axes of the volume that was given in memory.
  CtVolume as_given(const std::string& body, CtVolume ct) const;
  void drive(const std::string& tool, const std::vector<std::vector<double>>& rows);

 private:
  PyWorld(const Entered& entered, PyWorld& other, int threads);
  /// Without keeps_forces: empties the logs, and keeps them empty.
  void limit_logs();
  /// After another state has replaced one with these cuts: the snapshot is out of date. Its caches are
  /// discarded if they are those of other cuts.
  void forget_snapshot(std::uint64_t cuts_before);
  /// Throws Refused after begin_touch.
  void expect_no_touch(const char* call) const;
  /// Throws Refused if the world runs tick by tick, since a file has no state between two ticks.
  void expect_frames(const char* call) const;

  Exec exec_;
  std::shared_ptr<const Scene> scene_;
  std::map<std::string, Grid> left_handed_;  // of volumes in memory, by body
  std::unique_ptr<World> world_;             // must not move: patches under construction refer to it
  bool keeps_forces_ = true;
  std::optional<DrivenTicks> driven_;
  bool was_touched_ = false;  // by begin_touch, which ends ticks on this thread for good
  Measures measures_;
  LoadedWorld loaded_;  // for files of states
  std::vector<contact::ToolCommand> commands_;
  std::vector<contact::ToolReading> readings_;
  WorldSnapshot snapshot_;
  bool is_shown_ = false, has_writers_ = false;
  std::atomic<bool> busy_{false};
  std::atomic<bool> is_touched_{false}, is_ticking_{false};  // see begin_touch
};

/// Ticks many worlds in parallel, one thread per world; all worlds have the same number of tools. Arrays are
/// ordered by world.
void tick_worlds(const std::vector<PyWorld*>& worlds, std::size_t ticks, std::size_t tools,
                 const double* poses, const bool* holds, double* forces, int threads);

}  // namespace turgor

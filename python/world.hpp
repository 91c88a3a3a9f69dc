// A world as Python holds it: the scene, the bodies, what was measured, and who is at it now. While the
// engine works, other Python threads run; a world that works is not entered a second time.
#pragma once

#include <atomic>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "arrays.hpp"
#include "turgor/sim/live/driven_ticks.hpp"
#include "turgor/sim/report/measures.hpp"
#include "turgor/sim/snapshot.hpp"
#include "turgor/sim/world.hpp"
#include "turgor/sim/world_state.hpp"

namespace turgor {

/// Poses of a tick: x, y, z [m] and a quaternion w, x, y, z, for every tool.
using Poses = nb::ndarray<const double, nb::shape<-1, -1, 7>, nb::c_contig, nb::device::cpu>;
using Holds = nb::ndarray<const bool, nb::shape<-1, -1>, nb::c_contig, nb::device::cpu>;

/// Volumes that a caller has at hand, by the names of bodies.
struct Given {
  std::map<std::string, std::shared_ptr<const CtVolume>> volumes;
  std::map<std::string, std::shared_ptr<const LabelVolume>> labels;
};
/// Puts them into a scene. Error: there is no such lattice.
Status give(const Given& given, Scene& scene);

/// What changes of a world, and of what was measured in it.
struct PyState {
  std::shared_ptr<const Scene> scene;  // of which world it is
  WorldState state;
  std::optional<LedTicks> led;
  Measures measures;
};

class PyWorld {
 public:
  PyWorld(Scene scene, int threads, bool keeps_forces, const BeginWork& begin);
  /// Another world that goes on as this one does, with so many threads; 0 = as many.
  PyWorld(PyWorld& other, int threads);

  void step(int frames);
  /// Ticks · tools · 6 numbers: force [N] and torque [N·m] on every tool. The caller has let go of the
  /// interpreter's lock.
  void tick(std::size_t ticks, const double* poses, const bool* holds, double* forces);
  bool is_led() const { return led_.has_value(); }

  PyState state();
  void set_state(const PyState& state);

  const Scene& scene() const { return *scene_; }
  const Exec& exec() const { return exec_; }
  /// For those who look without letting other Python threads run: none of them can begin a step meanwhile.
  World& world() const;
  const Measures& measures() const { return world(), measures_; }
  /// As it is now.
  WorldSnapshot& snapshot();
  /// Somebody may write into the bodies from here on, so that they are shown anew whenever they are looked
  /// at.
  void expect_writers() { has_writers_ = true; }
  TouchingTool& tool(const std::string& name) const;
  void drive(const std::string& tool, const std::vector<std::vector<double>>& rows);

  /// One caller at a time.
  class Entered {
   public:
    explicit Entered(PyWorld& world);
    ~Entered() { world_.busy_ = false; }
    Entered(const Entered&) = delete;
    Entered& operator=(const Entered&) = delete;

   private:
    PyWorld& world_;
  };

 private:
  void limit_logs();

  Exec exec_;
  std::shared_ptr<const Scene> scene_;
  std::unique_ptr<World> world_;  // patches that are built know where it is
  bool keeps_forces_ = true;
  std::optional<LedTicks> led_;
  Measures measures_;
  std::vector<contact::ToolCommand> commands_;
  std::vector<contact::ToolReading> readings_;
  WorldSnapshot snapshot_;
  bool is_shown_ = false, has_writers_ = false;
  std::atomic<bool> busy_{false};
};

/// The same in many worlds beside each other, one thread each; all of them have as many tools. Arrays are
/// world by world.
void tick_worlds(const std::vector<PyWorld*>& worlds, std::size_t ticks, std::size_t tools,
                 const double* poses, const bool* holds, double* forces, int threads);

}  // namespace turgor

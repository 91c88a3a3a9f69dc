// Builds patches on a thread of its own, one at a time, as long as it lives.
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "turgor/core/result.hpp"
#include "turgor/models/sfem/patch.hpp"

namespace turgor {

struct BuiltPatch {
  Result<std::shared_ptr<const sfem::Patch>> patch;
  double seconds = 0;  // wall time of building it
};

/// For the frame's thread alone; a haptic thread never sees it.
class PatchWorker {
 public:
  using Build = std::function<BuiltPatch()>;

  PatchWorker();
  PatchWorker(const PatchWorker&) = delete;
  PatchWorker& operator=(const PatchWorker&) = delete;
  /// Waits for what is being built.
  ~PatchWorker();

  /// Nothing else was begun, or it was finished.
  void begin(Build build);
  /// Is there a patch that was begun and not yet finished?
  bool is_busy() const { return is_busy_; }
  /// Is it ready, so that finish does not wait?
  bool is_ready();
  /// What was begun; waits for it.
  BuiltPatch finish();

 private:
  void work();

  std::mutex mutex_;
  std::condition_variable changed_;
  Build build_;
  std::optional<BuiltPatch> built_;
  bool is_busy_ = false, ends_ = false;
  std::thread thread_;
};

}  // namespace turgor

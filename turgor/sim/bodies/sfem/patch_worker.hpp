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

  PatchWorker() = default;
  /// Waits until what the other builds is there: both have it.
  PatchWorker(const PatchWorker& other);
  PatchWorker& operator=(const PatchWorker&) = delete;
  /// Waits for what is being built.
  ~PatchWorker();

  /// Nothing else was begun, or it was finished.
  void begin(Build build);
  /// Is there a patch that was begun and not yet finished?
  bool is_busy() const { return is_busy_; }
  /// Is it ready, so that finish does not wait?
  bool is_ready();
  /// Waits for what was begun, if anything was: from here on nobody reads what it is built from.
  void settle() const;
  /// What was begun; waits for it.
  BuiltPatch finish();

 private:
  void work();

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  Build build_;
  std::optional<BuiltPatch> built_;
  bool is_busy_ = false, ends_ = false;
  std::thread thread_;  // from the first begin on
};

}  // namespace turgor

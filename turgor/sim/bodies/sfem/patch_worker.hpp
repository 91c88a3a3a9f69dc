// Thread that builds patches, one at a time.
#pragma once

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "turgor/core/result.hpp"
#include "turgor/models/sfem/nonlinear_patch.hpp"

namespace turgor {

struct BuiltPatch {
  Result<std::shared_ptr<const sfem::Patch>> patch;
  double seconds = 0;  // wall time of building
  std::shared_ptr<sfem::NonlinearPatch> nonlinear =
      {};                                         // a new one; null: a linear patch, or one solved again
  std::optional<sfem::NonlinearReport> law = {};  // of the solution of a nonlinear patch
};

/// Used by the frame thread only, never by the haptic thread.
class PatchWorker {
 public:
  using Build = std::function<BuiltPatch()>;

  PatchWorker() = default;
  /// Waits for the patch of `other`; both then hold it.
  PatchWorker(const PatchWorker& other);
  PatchWorker& operator=(const PatchWorker&) = delete;
  /// Waits for the patch under construction.
  ~PatchWorker();

  /// Requires that no other patch is under construction. If the system refuses a thread, the caller builds.
  void begin(Build build);
  /// True while a patch was begun and not finished.
  bool is_busy() const { return is_busy_; }
  /// True if finish would not wait.
  bool is_ready();
  /// Waits for the patch under construction; afterwards no thread reads its input.
  void settle() const;
  /// Returns the patch; waits for it.
  BuiltPatch finish();

 private:
  void work();

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  Build build_;
  std::optional<BuiltPatch> built_;
  bool is_busy_ = false, ends_ = false;
  std::thread thread_;  // runs from the first begin on
};

}  // namespace turgor

// Storage of the two-level preconditioner: the coarse operator of one step and its factor
// (solver/two_level.hpp).
#pragma once

#include <memory>

namespace turgor::cloth {

/// Coarse operator and factor. A copy has neither.
struct TwoLevelSystem {
  struct Storage;  // defined in solver/two_level.cpp

  TwoLevelSystem();
  ~TwoLevelSystem();
  TwoLevelSystem(const TwoLevelSystem&);
  TwoLevelSystem& operator=(const TwoLevelSystem&);

  std::unique_ptr<Storage> storage;
  bool is_factored = false;  // for the system that was assembled last
};

}  // namespace turgor::cloth

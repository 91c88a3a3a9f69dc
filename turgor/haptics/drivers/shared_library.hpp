// A vendor's library, found while the program runs.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"

namespace turgor::haptics {

/// Once loaded it stays: threads of a vendor and sentences that it owns outlive a device.
class SharedLibrary {
 public:
  SharedLibrary() = default;
  /// The first of these files that can be loaded. Error: what the loader said, a file that is there but
  /// cannot be loaded before one that is not.
  static Result<SharedLibrary> open(const std::vector<std::string>& candidates);

  /// Whether it has the symbol; `function` points to it then.
  template <class F>
  bool bind(const char* symbol, F*& function) const {
    function = reinterpret_cast<F*>(find(symbol));
    return function != nullptr;
  }
  const std::string& file() const { return file_; }

 private:
  void* find(const char* symbol) const;

  std::shared_ptr<void> handle_;
  std::string file_;
};

/// Files in a folder whose names begin with `stem` ("libdrd.so"), the highest version first.
std::vector<std::string> library_files(const std::string& folder, const std::string& stem);

/// An environment variable; empty when it is not set.
std::string environment(const char* name);

}  // namespace turgor::haptics

// Shared library of a vendor, loaded at run time.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "turgor/core/result.hpp"

namespace turgor::haptics {

/// Never unloaded: threads of a vendor and texts that it owns outlive a device.
class SharedLibrary {
 public:
  SharedLibrary() = default;
  /// Loads the first of these files that can be loaded. Error: the loader's message, preferably for a file
  /// that exists but cannot be loaded.
  static Result<SharedLibrary> open(const std::vector<std::string>& candidates);

  /// Binds `function` to a symbol. False when the library lacks it.
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

/// Value of an environment variable; empty when it is not set.
std::string environment(const char* name);

}  // namespace turgor::haptics

// Access of tests to the state of a fake library. Loading a file twice gives the same library as the
// driver's.
#pragma once

#include <dlfcn.h>
#include <gtest/gtest.h>

namespace turgor::test {

/// Result of the exported function `symbol`, which takes no arguments. The library stays loaded.
template <class T>
T* fake(const char* file, const char* symbol) {
  void* library = dlopen(file, RTLD_NOW);
  void* function = library ? dlsym(library, symbol) : nullptr;
  if (!function) ADD_FAILURE() << file << ": " << dlerror();
  return function ? reinterpret_cast<T* (*)()>(function)() : nullptr;
}

}  // namespace turgor::test

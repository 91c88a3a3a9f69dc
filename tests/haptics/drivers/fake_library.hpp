// The driver's view of a fake library and the test's: loading a file twice gives the same one.
#pragma once

#include <dlfcn.h>
#include <gtest/gtest.h>

namespace turgor::test {

/// What the library exports as `symbol`, a function without arguments, answers. The library stays loaded.
template <class T>
T* fake(const char* file, const char* symbol) {
  void* library = dlopen(file, RTLD_NOW);
  void* function = library ? dlsym(library, symbol) : nullptr;
  if (!function) ADD_FAILURE() << file << ": " << dlerror();
  return function ? reinterpret_cast<T* (*)()>(function)() : nullptr;
}

}  // namespace turgor::test

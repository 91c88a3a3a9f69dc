#include "allocations.hpp"

#include <cstdlib>
#include <new>

namespace turgor::test {
thread_local std::size_t allocations = 0;
}
using turgor::test::allocations;
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"  // GCC 12 sees malloc through the replaced operator
void* operator new(std::size_t size) {
  allocations++;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {  // of std::stable_sort
  allocations++;
  return std::malloc(size);
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  allocations++;
  const auto a = std::size_t(alignment);
  if (void* memory = std::aligned_alloc(a, (size + a - 1) / a * a)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

#include "haptics/allocations.hpp"

#include <cstdlib>
#include <new>

namespace {
thread_local std::size_t allocated = 0;
}
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"  // GCC 12 sees malloc through the replaced operator
void* operator new(std::size_t size) {
  allocated++;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {  // of std::stable_sort
  allocated++;
  return std::malloc(size);
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  allocated++;
  const auto a = std::size_t(alignment);
  if (void* memory = std::aligned_alloc(a, (size + a - 1) / a * a)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace turgor::haptics {

std::size_t allocations() { return allocated; }

}  // namespace turgor::haptics

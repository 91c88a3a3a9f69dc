// Two functions under the names that they had before glibc 2.35 and GCC 12, which give them still: nothing
// else of the slim module asks for more than glibc 2.34 and GCC 11. The linker sends every call of them here
// (--wrap). Below 2.34 it does not go on in this way: threads and dlopen moved into libc.so.6 then, which
// Debian's libtbb12 needs as well, and std::filesystem asks for a libstdc++ newer than that of GCC 8.
#include <condition_variable>
#include <mutex>

double older_hypot(double x, double y) noexcept asm("turgor_older_hypot");
void older_wait(std::condition_variable* condition,
                std::unique_lock<std::mutex>* lock) asm("turgor_older_wait");

asm(".symver turgor_older_hypot, hypot@GLIBC_2.2.5");
asm(".symver turgor_older_wait, _ZNSt18condition_variable4waitERSt11unique_lockISt5mutexE@GLIBCXX_3.4.11");

double hypot_of_any_glibc(double x, double y) noexcept asm("__wrap_hypot");
double hypot_of_any_glibc(double x, double y) noexcept { return older_hypot(x, y); }

void wait_of_any_gcc(std::condition_variable* condition, std::unique_lock<std::mutex>* lock) asm(
    "__wrap__ZNSt18condition_variable4waitERSt11unique_lockISt5mutexE");
void wait_of_any_gcc(std::condition_variable* condition, std::unique_lock<std::mutex>* lock) {
  older_wait(condition, lock);
}

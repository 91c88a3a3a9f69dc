// Older symbol versions of two functions, so that the slim module needs only glibc 2.34 and GCC 11. The
// linker redirects all calls to these wrappers (--wrap). Still older versions are not possible: in 2.34
// threads and dlopen moved into libc.so.6, which Debian's libtbb12 needs too, and std::filesystem needs a
// libstdc++ newer than GCC 8.
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

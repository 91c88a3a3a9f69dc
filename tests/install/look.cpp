// The whole library links: reading a wrong path returns an error message.
#include <cstdio>

#include <turgor/io/ct.hpp>

int main() {
  const auto ct = turgor::read_ct(turgor::Exec(), "no-such-folder/ct.nii.gz");
  std::printf("%s\n", ct ? "?" : ct.error().message.c_str());
  return ct ? 1 : 0;
}

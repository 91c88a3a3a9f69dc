// turgor-read: opens a file with HDF5 or GDCM for the library, in a sandbox
// (turgor/io/files/reader_protocol.hpp). It is started by turgor, not by people.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

#include <unistd.h>

#include "reader/sandbox.hpp"
#include "reader/tasks.hpp"
#include "turgor/io/files/child.hpp"
#include "turgor/io/files/reader_protocol.hpp"

namespace {

using namespace turgor;

std::size_t number(const char* text) { return std::strtoull(text, nullptr, 10); }

int run(int count, char** words) {
  if (count > 1 && std::atoi(words[1]) != io::kReaderProtocol) return io::kOtherProtocol;
  if (count == 5 && std::strcmp(words[3], "hdf5") == 0) {
    enter_sandbox(number(words[2]));
    return walk_through_hdf5(words[4]) ? io::kSound : io::kUnsound;
  }
  if (count == 6 && std::strcmp(words[3], "dicom") == 0) {
    enter_sandbox(number(words[2]));
    return decode_dicom(io::kSharedFile, number(words[4]), number(words[5])) ? io::kSound : io::kUnsound;
  }
  std::fputs("turgor-read is started by turgor to read HDF5 and DICOM files; it has no use by itself\n",
             stderr);
  return io::kWrongUse;
}

}  // namespace

int main(int count, char** words) {
  int status = io::kUnsound;
  try {
    status = run(count, words);
  } catch (const std::bad_alloc&) {
    status = io::kNoMemory;
  } catch (...) {
  }
  _exit(status);  // nothing is closed: a damaged file may crash the libraries' last steps
}

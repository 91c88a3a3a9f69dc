#include "turgor/core/disk_log.hpp"

#include <cerrno>
#include <cstdlib>
#include <string>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

namespace turgor {

namespace {

/// New file without a name; -1 if the folder does not allow it. /tmp is often in memory, /var/tmp is not.
int open_unnamed() {
  const char* chosen = std::getenv("TMPDIR");
  for (const std::string& folder : {std::string(chosen ? chosen : ""), std::string("/var/tmp")}) {
    if (folder.empty()) continue;
    std::string name = folder + "/turgor-XXXXXX";
    const int descriptor = mkostemp(name.data(), O_CLOEXEC);
    if (descriptor < 0) continue;
    unlink(name.c_str());
    return descriptor;
  }
  return -1;
}

}  // namespace

std::shared_ptr<TemporaryFile> TemporaryFile::create(std::size_t most) {
  const int descriptor = open_unnamed();
  if (descriptor < 0) return nullptr;
  // the mapping may be longer than the file; only written bytes are read
  void* const bytes = mmap(nullptr, most, PROT_READ, MAP_SHARED | MAP_NORESERVE, descriptor, 0);
  if (bytes == MAP_FAILED) {
    close(descriptor);
    return nullptr;
  }
  return std::shared_ptr<TemporaryFile>(
      new TemporaryFile(descriptor, static_cast<const std::byte*>(bytes), most));
}

TemporaryFile::~TemporaryFile() {
  munmap(const_cast<std::byte*>(bytes_), most_);
  close(descriptor_);
}

bool TemporaryFile::append(const void* bytes, std::size_t size) {
  TURGOR_ASSERT(size_ + size <= most_, "a temporary file stays within its limit");
  const char* const from = static_cast<const char*>(bytes);
  for (std::size_t done = 0; done < size;) {
    const ssize_t written = pwrite(descriptor_, from + done, size - done, off_t(size_ + done));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    done += std::size_t(written);
  }
  size_ += size;
  return true;
}

}  // namespace turgor

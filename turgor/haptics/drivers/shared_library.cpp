#include "turgor/haptics/drivers/shared_library.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include <dlfcn.h>
#include <fmt/format.h>
#include <string.h>  // strverscmp

namespace turgor::haptics {

namespace {

/// True when the loader's message says that this file does not exist. The loader uses the same words, with
/// another FILE, for a missing dependency.
bool is_absent(const std::string& file, const std::string& message) {
  return message.starts_with(file + ": cannot open shared object file");
}

}  // namespace

Result<SharedLibrary> SharedLibrary::open(const std::vector<std::string>& candidates) {
  std::string absent, broken;
  for (const std::string& file : candidates) {
    // loaded
    if (void* handle = dlopen(file.c_str(), RTLD_LAZY | RTLD_LOCAL | RTLD_NODELETE)) {
      SharedLibrary library;
      library.handle_ = std::shared_ptr<void>(handle, dlclose);
      library.file_ = file;
      return library;
    }
    // first message of each kind
    const char* reason = dlerror();
    const std::string message = reason ? reason : file + ": cannot be loaded";
    std::string& first_error = is_absent(file, message) ? absent : broken;
    if (first_error.empty()) first_error = message;
  }
  return Error{broken.empty() ? absent : broken};
}

void* SharedLibrary::find(const char* symbol) const {
  return handle_ ? dlsym(handle_.get(), symbol) : nullptr;
}

std::vector<std::string> library_files(const std::string& folder, const std::string& stem) {
  std::vector<std::string> files;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error))
    if (entry->path().filename().string().starts_with(stem)) files.push_back(entry->path().string());
  std::sort(files.begin(), files.end(),
            [](const auto& a, const auto& b) { return strverscmp(a.c_str(), b.c_str()) > 0; });
  return files;
}

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

}  // namespace turgor::haptics

// `turgor cache`: lists or clears the Green's functions cached between runs.
#include <ctime>
#include <memory>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "app/commands.hpp"
#include "app/print.hpp"
#include "turgor/sim/bodies/sfem/green_cache.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

struct CacheOptions {
  std::string folder;  // empty = the user's cache folder
  bool clear = false;
};

std::string day(fs::file_time_type time) {
  const auto system = std::chrono::file_clock::to_sys(time);
  const std::time_t seconds =
      std::chrono::system_clock::to_time_t(std::chrono::time_point_cast<std::chrono::seconds>(system));
  std::tm local{};
  localtime_r(&seconds, &local);
  return fmt::format("{:%Y-%m-%d %H:%M}", local);
}

void print_files(const fs::path& folder, const CacheFolder& found) {
  double bytes = 0;
  for (const CacheFile& file : found.files) {
    bytes += double(file.bytes);
    print_plain("  {}  {:9.1f} MB  used {}  {}\n", file.file.filename().string(), double(file.bytes) * 1e-6,
                day(file.used), file.what_for.empty() ? "unknown body" : file.what_for);
  }
  print_plain("{}: {} files, {:.1f} MB; the limit is {:.1f} GB (TURGOR_CACHE_LIMIT)\n", folder.string(),
              found.files.size(), bytes * 1e-6, double(required(cache_limit())) * 1e-9);
}

void clear(const fs::path& folder, const CacheFolder& found) {
  const std::size_t removed = trim_cache(folder, 0).size();
  print_plain("{}: {} files removed\n", folder.string(), removed);
  if (removed < found.files.size())
    throw Failure{
        2, fmt::format("{}: {} files could not be removed", folder.string(), found.files.size() - removed)};
}

void run_cache(const CacheOptions& options) {
  const fs::path folder = options.folder.empty() ? user_cache_folder() : fs::path(options.folder);
  if (folder.empty()) throw Failure{2, "no cache folder: neither XDG_CACHE_HOME nor HOME is set"};
  if (options.clear)
    if (const std::size_t leftovers = remove_cache_leftovers(folder).size(); leftovers > 0)
      print_plain("{}: {} unfinished files of killed programs removed\n", folder.string(), leftovers);
  const CacheFolder found = required(list_cache(folder));
  if (options.clear)
    clear(folder, found);
  else
    print_files(folder, found);
  for (const fs::path& file : found.foreign)
    print_plain("  kept, not a complete cache file: {}\n", file.filename().string());
}

}  // namespace

void add_cache_command(CLI::App& program) {
  CLI::App* command = program.add_subcommand("cache", "List or clear the files cached between runs");
  auto options = std::make_shared<CacheOptions>();
  command->add_option("--folder", options->folder,
                      "Use this folder instead of the user's, as --set body.NAME.cache does");
  command->add_flag("--clear", options->clear, "Remove the cache files; other files stay");
  command->footer("Examples:\n  turgor cache\n  turgor cache --clear");
  command->callback([options] { run_cache(*options); });
}

}  // namespace turgor

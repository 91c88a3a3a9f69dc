#include "turgor/sim/autosave/saved_world.hpp"

#include <system_error>

#include <fmt/format.h>

#include "turgor/core/hash.hpp"
#include "turgor/sim/autosave/transfer_snapshot.hpp"
#include "turgor/sim/report/report.hpp"
#include "turgor/sim/world_state.hpp"

namespace turgor {

namespace {

namespace fs = std::filesystem;

/// Program, scene and inputs that a saved world belongs to.
struct SavedHeader {
  std::string program, scene;
  std::vector<std::string> overrides;
  std::uint64_t loaded = 0;
};
template <class File>
void transfer(File& file, SavedHeader& header) {
  transfer_all(file, header.program, header.scene, header.overrides, header.loaded);
}

SavedHeader header_of(const Scene& scene, const LoadedWorld& loaded) {
  return {state_program(), scene.text, scene.overrides, loaded.hash};
}

Status check_saved(const fs::path& path, const SavedHeader& found, const SavedHeader& expected) {
  const auto refuse = [&](const char* what, const std::string& more) {
    return Error{fmt::format("{}: the saved world is of {}{}", path.string(), what, more)};
  };
  if (found.program != expected.program)
    return refuse("another program", fmt::format(": expected {}, found {}", expected.program, found.program));
  if (found.scene != expected.scene || found.overrides != expected.overrides)
    return refuse("another scene, or of other overrides", "");
  if (found.loaded != expected.loaded) return refuse("other inputs: its CT or meshes have changed", "");
  return Done{};
}

}  // namespace

/// Number of changes to the content of states that no size of a struct shows.
constexpr std::size_t kContentChanges = 1;

std::string state_program(std::vector<std::size_t> more) {
  more.insert(more.end(), {kContentChanges, sizeof(World), sizeof(SfemBody), sizeof(RhombusBody),
                           sizeof(LatticeBody), sizeof(ClothBody), sizeof(Measures), sizeof(ForceSample),
                           sizeof(TouchingTool), sizeof(sfem::Patch)});
  return fmt::format("turgor {} for {}, states {}", program_version(), program_instructions(),
                     hash_text(hash_values(std::span<const std::size_t>(more))));
}

LoadedWorld loaded_world(const World& world) { return {loaded_patches(world), loaded_hash(world)}; }

Status save_world(const fs::path& path, const Scene& scene, const World& world, const Measures& measures,
                  const LoadedWorld& loaded) {
  const fs::path unfinished = path.string() + ".unfinished";
  Result<StateWriter> file = StateWriter::create(unfinished);
  if (!file) return file.error();
  SavedHeader header = header_of(scene, loaded);
  transfer(*file, header);
  write_world(*file, world, loaded.patches);
  transfer(*file, const_cast<Measures&>(measures));  // a writer changes nothing
  Status closed = file->close();
  std::error_code failed;
  if (closed) fs::rename(unfinished, path, failed);
  if (failed) closed = Error{fmt::format("{}: {}", path.string(), failed.message())};
  if (!closed) fs::remove(unfinished, failed);
  return closed;
}

Status read_saved_world(const Exec& exec, const fs::path& path, const Scene& scene, const LoadedWorld& loaded,
                        World& world, Measures& measures) {
  Result<StateReader> file = StateReader::open(path);
  if (!file) return file.error();
  SavedHeader header;
  transfer(*file, header);
  const Error damaged{fmt::format("{}: the saved world is damaged", path.string())};
  if (!file->is_sound()) return damaged;
  if (const Status same = check_saved(path, header, header_of(scene, loaded)); !same) return same;
  // into copies, so that a damaged file changes nothing
  World read = copy_of(world);
  Measures read_measures = measures;
  read_world(exec, *file, loaded.patches, read);
  transfer(*file, read_measures);
  if (!file->is_at_end()) return damaged;
  take_state(world, read), measures = std::move(read_measures);
  return Done{};
}

}  // namespace turgor

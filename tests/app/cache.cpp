// The cache of Green's functions: `turgor cache`, and the folders that recordings choose.
#include "tests/app/pressed_pad.hpp"
#include "tests/app/program.hpp"
#include "tests/sim/renamed_datasets.hpp"

namespace turgor {
namespace {

using namespace test;

/// Writes a copy of an HDF5 file in which some texts are others.
void write_with_texts(const fs::path& from, const fs::path& to,
                      const std::map<std::string, std::string>& texts) {
  const Result<Hdf5File> source = Hdf5File::open(from);
  Result<Hdf5File> target = Hdf5File::create(to);
  ASSERT_TRUE(source && target);
  for (const std::string& path : source->datasets()) {
    const auto changed = texts.find(path);
    EXPECT_TRUE(changed == texts.end() ? copy_dataset(*source, *target, path, path)
                                       : bool(target->write_text(path, changed->second)))
        << path;
  }
  EXPECT_TRUE(target->close());
}

// A haptic recording of another person writes nothing outside --out and the user's cache, whatever folder its
// overrides or its scene choose, even if it states no folder of the run.
TEST(CacheFolder, RecordingChoosesNoForeignFolder) {
  const fs::path folder = fresh_folder(), foreign = folder / "foreign", outs = folder / "outs";
  std::string text = pressed_pad_text(0.5, 0.1);
  text.replace(text.find("cache = false"), 13, "# cache");
  write(folder / "pad.toml", text);
  const Ended recorded = run_program(
      "run pad.toml --real-time -q --out o --set body.pad.cache='" + foreign.string() + "'", folder);
  ASSERT_EQ(recorded.code, 0) << recorded.printed;
  ASSERT_TRUE(fs::exists(foreign)) << "the person at the command line chooses any folder";
  fs::remove_all(foreign);
  fs::create_directory(outs);

  // as recorded, without the folder of the run, and with the choice in the scene
  std::string choosing = text;
  choosing.replace(choosing.find("# cache"), 7, "cache = \"" + foreign.string() + "\"");
  const std::map<std::string, std::string> changes[] = {
      {}, {{"/scene/folder", ""}}, {{"/scene/text", choosing}, {"/scene/overrides", "[]"}}};
  const std::set<std::string> before = names_in(folder);
  for (std::size_t n = 0; n < std::size(changes); n++) {
    write_with_texts(folder / "o/haptic.h5", outs / "haptic.h5", changes[n]);
    const std::string out = "outs/" + std::to_string(n);
    const Ended again = run_program("--threads 1 replay outs/haptic.h5 -q --out " + out, folder);
    ASSERT_EQ(again.code, 0) << n << ": " << again.printed;
    const std::string warnings = report_in(folder / out)["warnings"].dump();
    EXPECT_NE(warnings.find("is not below the user's cache folder, which is used instead"), std::string::npos)
        << n << ": " << warnings;
    EXPECT_FALSE(fs::exists(foreign)) << n;
  }
  EXPECT_EQ(names_in(folder), before);
}

// `turgor cache --clear` removes cache files and what killed runs left, not foreign files.
TEST(CacheFolder, ClearRemovesLeftoversOfKilledRuns) {
  const fs::path folder = fresh_folder(), kept = folder / "kept";
  write(folder / "pad.toml", pressed_pad_text(0.1, 0));
  const Ended ended = run_program("run pad.toml -q --out o --set body.pad.cache=kept", folder);
  ASSERT_EQ(ended.code, 0) << ended.printed;
  ASSERT_EQ(names_in(kept).size(), 1u);
  const Ended ended_process = run_shell("sh -c 'echo $$; exec sleep 0'", folder);
  const std::string left =
      ".green-0123456789abcdef.h5.partial-" + std::to_string(std::stoi(ended_process.printed)) + "-0";
  write(kept / left, "half");
  write(kept / ("." + left.substr(1 + std::string("green-0123456789abcdef").size())), "of another program");
  write(kept / "notes.txt", "foreign");
  const Ended listed = run_program("cache --folder kept", folder);
  EXPECT_EQ(listed.code, 0) << listed.printed;
  EXPECT_TRUE(fs::exists(kept / left)) << "listing removes nothing";
  const Ended cleared = run_program("cache --clear --folder kept", folder);
  EXPECT_EQ(cleared.code, 0) << cleared.printed;
  EXPECT_NE(cleared.printed.find(": 1 unfinished files of killed programs removed"), std::string::npos)
      << cleared.printed;
  EXPECT_NE(cleared.printed.find(": 1 files removed"), std::string::npos) << cleared.printed;
  EXPECT_FALSE(fs::exists(kept / left));
  EXPECT_TRUE(fs::exists(kept / "notes.txt"));
  EXPECT_EQ(names_in(kept).size(), 2u);
}

}  // namespace
}  // namespace turgor

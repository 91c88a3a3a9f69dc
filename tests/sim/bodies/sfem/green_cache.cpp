#include "turgor/sim/bodies/sfem/green_cache.hpp"

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <random>
#include <thread>

#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/sim/sfem_scene_text.hpp"
#include "tests/small_disk.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/io/files/file.hpp"
#include "turgor/io/files/hdf5_file.hpp"

namespace turgor {
namespace {

namespace fs = std::filesystem;

sfem::Body block_body(double young = 1e4) {
  sfem::Body body;
  body.mesh = hex_block({0.04, 0.04, 0.02}, {4, 4, 2});
  body.materials = {{young, 0.3}};
  for (const Vec3d x : body.mesh.vertices) body.fixed.push_back(x.z == 0);
  return body;
}

sfem::Model built(double young = 1e4, sfem::Precision precision = sfem::Precision::kSingle) {
  const sfem::Params params{.precision = precision, .touch_depth = 1};
  return sfem::build(Exec(1), block_body(young), params).value();
}

sfem::Model computed(sfem::Precision precision = sfem::Precision::kSingle) {
  sfem::Model model = built(1e4, precision);
  EXPECT_TRUE(sfem::compute_green(Exec(1), model, std::size_t(1) << 30));
  return model;
}

// A cache file is read back bit for bit.
TEST(GreenCache, RoundTripKeepsBits) {
  const fs::path file = test::fresh_folder() / "deep" / "green.h5";
  for (const auto precision : {sfem::Precision::kSingle, sfem::Precision::kDouble}) {
    const sfem::Model model = computed(precision);
    ASSERT_TRUE(write_green(file, model));
    sfem::Model again = built(1e4, precision);
    const CachedGreen cached = read_green(file, again);
    EXPECT_TRUE(cached.found) << cached.note;
    EXPECT_EQ(again.green.single_values, model.green.single_values);
    EXPECT_EQ(again.green.double_values, model.green.double_values);
  }
  EXPECT_EQ(test::names_in(file.parent_path()), std::set<std::string>{"green.h5"});
}

// On a full disk the write fails and the earlier file remains.
TEST(GreenCache, FullDiskKeepsEarlierFile) {
  const fs::path folder = test::fresh_folder(), file = folder / "green.h5";
  const sfem::Model model = computed();
  test::write(file, "earlier");
  for (const rlim_t bytes : {100, 3000, 30000})
    EXPECT_TRUE(test::on_a_small_disk(bytes, [&] {
      const Status written = write_green(file, model);
      return !written && written.error().message.find("cannot") != std::string::npos;
    })) << bytes;
  EXPECT_EQ(test::bytes_of(file), "earlier");
  EXPECT_EQ(test::names_in(folder), std::set<std::string>{"green.h5"});
}

// A missing cache file adds no note.
TEST(GreenCache, MissingFileAddsNoNote) {
  sfem::Model model = built();
  const CachedGreen cached = read_green(test::fresh_folder() / "none.h5", model);
  EXPECT_FALSE(cached.found);
  EXPECT_EQ(cached.note, "");
}

// The cache of another body is named and not used.
TEST(GreenCache, RejectsOtherBody) {
  const fs::path file = test::fresh_folder() / "green.h5";
  const sfem::Model model = computed();
  ASSERT_TRUE(write_green(file, model));
  sfem::Model stiffer = built(2e4);
  const CachedGreen cached = read_green(file, stiffer);
  EXPECT_FALSE(cached.found);
  EXPECT_EQ(cached.note, file.string() + ": it is of another body: expected content " +
                             hash_text(sfem::content_hash(stiffer)) + ", found " +
                             hash_text(sfem::content_hash(model)) + "; recomputed");
  EXPECT_TRUE(stiffer.green.single_values.empty());
}

// Foreign files are named and not used.
TEST(GreenCache, RejectsForeignFiles) {
  const fs::path file = test::fresh_folder() / "green.h5";
  sfem::Model model = built();
  ASSERT_TRUE(write_file(file, "not at all"));
  EXPECT_NE(read_green(file, model).note.find("expected an HDF5 file, found something else"),
            std::string::npos);
  {
    Result<Hdf5File> foreign = Hdf5File::create(file);
    ASSERT_TRUE(foreign);
    ASSERT_TRUE(foreign->write_text("/title", "weather of 1987"));
  }
  EXPECT_NE(read_green(file, model).note.find("found another HDF5 file"), std::string::npos);
}

// Truncated files and files with a changed byte are never used.
TEST(GreenCache, RejectsDamagedFiles) {
  const fs::path file = test::fresh_folder() / "green.h5";
  ASSERT_TRUE(write_green(file, computed()));
  const std::string whole = read_file(file).value();
  sfem::Model model = built();
  int used = 0, noted = 0;
  const auto attempt = [&](const std::string& bytes) {
    ASSERT_TRUE(write_file(file, bytes));
    const CachedGreen cached = read_green(file, model);
    used += cached.found;
    noted += !cached.note.empty();
  };
  for (std::size_t n = 1; n < 20; n++) attempt(whole.substr(0, whole.size() * n / 20));
  EXPECT_EQ(used, 0);
  for (std::size_t n = 0; n < 100; n++) {  // one byte within the values
    std::string damaged = whole;
    const std::size_t i = whole.size() / 4 + n * (whole.size() / 2 / 100);
    damaged[i] = char(damaged[i] ^ 0x10);
    attempt(damaged);
  }
  EXPECT_EQ(used, 0);
  EXPECT_EQ(noted, 119);
}

// Random mutations of a file never yield wrong values and never crash.
TEST(GreenCache, MutationsNeverYieldWrongValues) {
  const fs::path file = test::fresh_folder() / "green.h5";
  const sfem::Model right = computed(), empty = built();
  ASSERT_TRUE(write_green(file, right, "scene.toml: body.x"));
  const std::string whole = read_file(file).value();
  std::mt19937 random(11);
  const auto up_to = [&](std::size_t n) { return std::size_t(random()) % n; };
  for (int n = 0; n < 400; n++) {
    std::string bytes = whole;
    const std::size_t header =
        std::min<std::size_t>(whole.size(), 4096);  // half of them in the metadata of HDF5
    for (std::size_t k = 0; k <= up_to(6); k++) bytes[up_to(n % 2 ? header : bytes.size())] = char(random());
    if (n % 10 == 0) bytes.resize(up_to(bytes.size()));
    ASSERT_TRUE(write_file(file, bytes));
    sfem::Model model = empty;
    const CachedGreen cached = read_green(file, model);
    if (cached.found) {
      ASSERT_EQ(model.green.single_values, right.green.single_values) << n;
    } else {
      ASSERT_NE(cached.note, "") << n;
    }
    ASSERT_TRUE(list_cache(file.parent_path()));
  }
}

// Folders, links and foreign files in the cache folder are listed and never removed.
TEST(GreenCache, KeepsFoldersLinksAndForeignFiles) {
  const fs::path folder = test::fresh_folder();
  const sfem::Model model = computed();
  const fs::path ours = folder / "green-0123456789abcdef.h5", other = folder / "green-0000000000000000.h5";
  ASSERT_TRUE(write_green(ours, model, "scene.toml:3: body.x"));
  fs::create_directory(other);  // a folder with the name of a cache file
  ASSERT_TRUE(write_file(folder / "green-1111111111111111.h5", "not at all"));  // damaged
  ASSERT_TRUE(write_file(folder / "thesis.txt", "work"));                       // foreign
  ASSERT_TRUE(write_file(folder / "elsewhere", "precious"));
  fs::create_symlink(folder / "elsewhere", folder / "green-2222222222222222.h5");
  sfem::Model again = built();
  EXPECT_NE(read_green(other, again).note, "");
  EXPECT_FALSE(write_green(other, model)) << "a folder is not replaced";
  const Result<CacheFolder> found = list_cache(folder);
  ASSERT_TRUE(found);
  ASSERT_EQ(found->files.size(), 1u);
  EXPECT_EQ(found->files[0].file, ours);
  EXPECT_EQ(found->files[0].what_for, "scene.toml:3: body.x");
  EXPECT_EQ(found->foreign.size(), 5u);
  EXPECT_EQ(trim_cache(folder, 0).size(), 1u);
  EXPECT_EQ(test::names_in(folder),
            (std::set<std::string>{"green-0000000000000000.h5", "green-1111111111111111.h5",
                                   "green-2222222222222222.h5", "thesis.txt", "elsewhere"}));
  EXPECT_TRUE(list_cache(folder / "none")->files.empty());
  EXPECT_FALSE(list_cache(folder / "thesis.txt"));
}

// Trimming removes the least recently used files and never the current one.
TEST(GreenCache, TrimRemovesLeastRecentlyUsed) {
  const fs::path folder = test::fresh_folder();
  const sfem::Model model = computed();
  std::vector<fs::path> files;
  for (const char c : std::string("abcd")) {
    files.push_back(folder / ("green-" + std::string(16, c) + ".h5"));
    ASSERT_TRUE(write_green(files.back(), model));
    fs::last_write_time(files.back(),
                        fs::file_time_type::clock::now() - std::chrono::hours(10 - int(files.size())));
  }
  sfem::Model again = built();
  ASSERT_TRUE(read_green(files[0], again).found);  // marks the oldest as used
  const std::uintmax_t one = fs::file_size(files[0]);
  const std::vector<CacheFile> removed = trim_cache(folder, 2 * one, files[1]);
  ASSERT_EQ(removed.size(), 2u);
  EXPECT_EQ(removed[0].file, files[2]) << "the oldest except the current file";
  EXPECT_EQ(removed[1].file, files[3]);
  EXPECT_TRUE(fs::exists(files[0]) && fs::exists(files[1]));
  EXPECT_EQ(trim_cache(folder, 0, files[1]).size(), 1u);
  EXPECT_TRUE(fs::exists(files[1])) << "the current file stays even above the limit";
}

// A run keeps the cache below its limit; invalid limits are refused.
TEST(GreenCache, RunRespectsLimit) {
  const fs::path folder = test::fresh_folder();
  const Exec exec(1);
  setenv("TURGOR_CACHE_LIMIT", "0.000001", 1);
  const World first = test::sfem_world(exec, test::body_scene(folder));
  const World second = test::sfem_world(exec, test::body_scene(folder, "", {"body.pad.young=6e3"}));
  EXPECT_EQ(test::names_in(folder / "cache").size(), 1u);
  ASSERT_FALSE(second.sfem_bodies[0].facts.notes.empty());
  EXPECT_NE(second.sfem_bodies[0].facts.notes[0].find("1 least recently used files of"), std::string::npos);
  EXPECT_TRUE(fs::exists(second.sfem_bodies[0].facts.cache_file));
  for (const char* text : {"many", "-1", "nan", "1e300", "3 GB"}) {
    setenv("TURGOR_CACHE_LIMIT", text, 1);
    EXPECT_FALSE(cache_limit()) << text;
  }
  unsetenv("TURGOR_CACHE_LIMIT");
  EXPECT_EQ(*cache_limit(), std::uintmax_t(10e9));
}

// Unfinished files of ended programs are removed; those of running ones and foreign ones stay.
TEST(GreenCache, RemovesLeftoversOfKilled) {
  const fs::path folder = test::fresh_folder();
  const pid_t child = fork();
  if (child == 0) _exit(0);
  waitpid(child, nullptr, 0);
  const auto name = [](pid_t id) {
    return ".green-0123456789abcdef.h5.partial-" + std::to_string(id) + "-0";
  };
  for (const std::string& file : {name(child), name(getpid()), ".other.partial-" + std::to_string(child)})
    test::write(folder / file, "half");
  EXPECT_EQ(remove_cache_leftovers(folder), std::vector<fs::path>{folder / name(child)});
  EXPECT_EQ(test::names_in(folder).size(), 2u);
}

// Wrong values with valid checksums are detected against the body.
TEST(GreenCache, DetectsWrongValues) {
  const fs::path file = test::fresh_folder() / "green.h5";
  sfem::Model model = computed();
  model.green.single_values[model.green.single_values.size() / 2] *= 1.01f;  // the file's checksums agree
  ASSERT_TRUE(write_green(file, model));
  sfem::Model again = built();
  const CachedGreen cached = read_green(file, again);
  EXPECT_FALSE(cached.found);
  EXPECT_NE(cached.note.find("recomputed"), std::string::npos) << cached.note;
}

// A world reads its cache and recomputes a damaged file.
TEST(GreenCache, WorldRebuildsDamagedFile) {
  const fs::path folder = test::fresh_folder();
  const Scene scene = test::body_scene(folder);
  const Exec exec(1);
  const World first = test::sfem_world(exec, scene);
  EXPECT_FALSE(first.sfem_bodies[0].facts.from_cache);
  const World second = test::sfem_world(exec, scene);
  EXPECT_TRUE(second.sfem_bodies[0].facts.from_cache);
  const fs::path file = second.sfem_bodies[0].facts.cache_file;
  ASSERT_TRUE(write_file(file, read_file(file).value().substr(0, 5000)));
  const World third = test::sfem_world(exec, scene);
  EXPECT_FALSE(third.sfem_bodies[0].facts.from_cache);
  ASSERT_EQ(third.sfem_bodies[0].facts.notes.size(), 1u);
  EXPECT_NE(third.sfem_bodies[0].facts.notes[0].find("recomputed"), std::string::npos);
  EXPECT_TRUE(test::sfem_world(exec, scene).sfem_bodies[0].facts.from_cache);
}

// Worlds that start in several threads all read a warm cache, and none rewrites it.
TEST(GreenCache, WorldsInThreadsReadWarmCache) {
  const Scene scene = test::body_scene(test::fresh_folder());
  const fs::path file = test::sfem_world(Exec(1), scene).sfem_bodies[0].facts.cache_file;
  const auto inode = [&] {
    struct stat status {};
    return stat(file.c_str(), &status) == 0 ? status.st_ino : 0;
  };
  const auto written = inode();
  std::atomic<int> from_cache{0};
  std::vector<std::thread> threads;
  const auto begin = std::chrono::steady_clock::now();
  for (int t = 0; t < 8; t++)
    threads.emplace_back([&] {
      for (int n = 0; n < 3; n++) {
        const Result<World> world = load_world(Exec(1), scene);
        from_cache += world && world->sfem_bodies[0].facts.from_cache;
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(from_cache, 8 * 3);
  EXPECT_EQ(inode(), written) << "the file was replaced";
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(18));
}

// Without turgor-read a world computes its functions, says so, and keeps the file.
TEST(GreenCache, MissingReaderKeepsFile) {
  const Scene scene = test::body_scene(test::fresh_folder());
  const fs::path file = test::sfem_world(Exec(1), scene).sfem_bodies[0].facts.cache_file;
  const std::string bytes = test::bytes_of(file);
  const auto time = fs::last_write_time(file);
  setenv("TURGOR_READ", "/no/such/turgor-read", 1);
  const World world = test::sfem_world(Exec(1), scene);
  unsetenv("TURGOR_READ");
  EXPECT_FALSE(world.sfem_bodies[0].facts.from_cache);
  ASSERT_EQ(world.sfem_bodies[0].facts.notes.size(), 1u);
  EXPECT_NE(world.sfem_bodies[0].facts.notes[0].find("TURGOR_READ"), std::string::npos);
  EXPECT_EQ(fs::last_write_time(file), time);
  EXPECT_EQ(test::bytes_of(file), bytes);
  EXPECT_TRUE(test::sfem_world(Exec(1), scene).sfem_bodies[0].facts.from_cache);
}

// A turgor-read that gives no verdict leaves a sound cached file as it is: another version, missing
// libraries, no executable.
TEST(GreenCache, ReaderWithoutVerdictKeepsFile) {
  const Scene scene = test::body_scene(test::fresh_folder());
  const fs::path file = test::sfem_world(Exec(1), scene).sfem_bodies[0].facts.cache_file;
  const std::string bytes = test::bytes_of(file);
  const auto time = fs::last_write_time(file);
  for (const char* text : {"#!/bin/sh\nexit 253\n", "#!/bin/sh\nexit 127\n",
                           "\x7f"
                           "ELF"}) {
    const fs::path program = test::fresh_folder() / "turgor-read";
    test::write(program, text);
    fs::permissions(program, fs::perms::owner_all);
    setenv("TURGOR_READ", program.c_str(), 1);
    const World world = test::sfem_world(Exec(1), scene);
    unsetenv("TURGOR_READ");
    EXPECT_FALSE(world.sfem_bodies[0].facts.from_cache) << text;
    ASSERT_EQ(world.sfem_bodies[0].facts.notes.size(), 1u) << text;
    EXPECT_NE(world.sfem_bodies[0].facts.notes[0].find("cannot be checked"), std::string::npos)
        << world.sfem_bodies[0].facts.notes[0];
    EXPECT_EQ(fs::last_write_time(file), time) << text;
    EXPECT_EQ(test::bytes_of(file), bytes) << text;
  }
}

}  // namespace
}  // namespace turgor

#include "turgor/sim/green_cache.hpp"

#include "sim/organ_scene.hpp"
#include "small_disk.hpp"
#include "turgor/core/hash.hpp"
#include "turgor/geometry/hex_block.hpp"
#include "turgor/io/file.hpp"
#include "turgor/io/hdf5_file.hpp"

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

TEST(GreenCache, WhatIsReadIsWhatWasWrittenToTheBit) {
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

TEST(GreenCache, OnAFullDiskNothingIsKeptAndTheEarlierFileStays) {
  const fs::path folder = test::fresh_folder(), file = folder / "green.h5";
  const sfem::Model model = computed();
  test::write(file, "earlier");
  for (const rlim_t bytes : {100, 3000, 30000})
    EXPECT_TRUE(test::on_a_small_disk(bytes, [&] {
      const Status kept = write_green(file, model);
      return !kept && kept.error().message.find("cannot") != std::string::npos;
    })) << bytes;
  EXPECT_EQ(test::bytes_of(file), "earlier");
  EXPECT_EQ(test::names_in(folder), std::set<std::string>{"green.h5"});
}

TEST(GreenCache, NoFileIsNoReasonForANote) {
  sfem::Model model = built();
  const CachedGreen cached = read_green(test::fresh_folder() / "none.h5", model);
  EXPECT_FALSE(cached.found);
  EXPECT_EQ(cached.note, "");
}

TEST(GreenCache, TheCacheOfAnotherBodyIsNamedAndNotUsed) {
  const fs::path file = test::fresh_folder() / "green.h5";
  const sfem::Model model = computed();
  ASSERT_TRUE(write_green(file, model));
  sfem::Model stiffer = built(2e4);
  const CachedGreen cached = read_green(file, stiffer);
  EXPECT_FALSE(cached.found);
  EXPECT_EQ(cached.note, file.string() + ": it belongs to another body: expected content " +
                             hash_text(sfem::content_hash(stiffer)) + ", found " +
                             hash_text(sfem::content_hash(model)) + "; computed anew");
  EXPECT_TRUE(stiffer.green.single_values.empty());
}

TEST(GreenCache, ForeignFilesAreNamed) {
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

TEST(GreenCache, DamagedAndCutOffFilesAreNeverUsed) {
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

TEST(GreenCache, ValuesThatAreWholeButWrongAreFoundByTheBody) {
  const fs::path file = test::fresh_folder() / "green.h5";
  sfem::Model model = computed();
  model.green.single_values[model.green.single_values.size() / 2] *= 1.01f;  // the file's checksums agree
  ASSERT_TRUE(write_green(file, model));
  sfem::Model again = built();
  const CachedGreen cached = read_green(file, again);
  EXPECT_FALSE(cached.found);
  EXPECT_NE(cached.note.find("computed anew"), std::string::npos) << cached.note;
}

TEST(GreenCache, AWorldComputesOnceAndRebuildsWhatIsDamaged) {
  const fs::path folder = test::fresh_folder();
  const Scene scene = test::organ_scene(folder);
  const Exec exec(1);
  const World first = test::organ_world(exec, scene);
  EXPECT_FALSE(first.organs[0].facts.from_cache);
  const World second = test::organ_world(exec, scene);
  EXPECT_TRUE(second.organs[0].facts.from_cache);
  const fs::path file = second.organs[0].facts.cache_file;
  ASSERT_TRUE(write_file(file, read_file(file).value().substr(0, 5000)));
  const World third = test::organ_world(exec, scene);
  EXPECT_FALSE(third.organs[0].facts.from_cache);
  ASSERT_EQ(third.organs[0].facts.notes.size(), 1u);
  EXPECT_NE(third.organs[0].facts.notes[0].find("computed anew"), std::string::npos);
  EXPECT_TRUE(test::organ_world(exec, scene).organs[0].facts.from_cache);
}

}  // namespace
}  // namespace turgor

// `turgor tissues` as a user runs it.
#include "tests/app/program.hpp"

namespace turgor {
namespace {

using namespace test;

// Every preset is printed and written with values, units, test, species and source.
TEST(TissuesCommand, ListsEveryPreset) {
  const fs::path folder = fresh_folder();
  const Ended ended = run_program("tissues --json tissues.json", folder);
  EXPECT_EQ(ended.code, 0) << ended.printed;
  const nlohmann::json found = read_json(folder / "tissues.json");
  ASSERT_GE(found["presets"].size(), 40u);
  for (const nlohmann::json& preset : found["presets"]) {
    EXPECT_NE(ended.printed.find(preset["name"].get<std::string>()), std::string::npos);
    for (const char* key : {"law", "test", "species", "source"}) EXPECT_NE(preset[key], "") << preset["name"];
    for (const nlohmann::json& value : preset["values"]) EXPECT_NE(value["unit"], "") << preset["name"];
  }
  EXPECT_NE(ended.printed.find("6 to 138 N/m"), std::string::npos);
}

// A name lists one preset; an unknown one is refused with the nearest name.
TEST(TissuesCommand, SuggestsNearestName) {
  const Ended one = run_program("tissues fat", fresh_folder());
  EXPECT_EQ(one.code, 0) << one.printed;
  EXPECT_NE(one.printed.find("Sims"), std::string::npos) << one.printed;
  EXPECT_EQ(one.printed.find("Samani"), std::string::npos) << one.printed;
  const Ended unknown = run_program("tissues livre", fresh_folder());
  EXPECT_EQ(unknown.code, 2);
  EXPECT_NE(unknown.printed.find("did you mean liver?"), std::string::npos) << unknown.printed;
}

}  // namespace
}  // namespace turgor

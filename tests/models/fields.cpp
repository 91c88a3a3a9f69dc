// What visit_fields says of a field is what hashes and sizes do with it.
#include "turgor/models/cloth/model/fields.hpp"

#include "tests/models/cloth/sheets.hpp"
#include "tests/models/lattice/block_body.hpp"
#include "turgor/core/field.hpp"
#include "turgor/geometry/label_measures.hpp"
#include "turgor/models/lattice/model/fields.hpp"

namespace turgor {
namespace {

/// Adds one to the number of an entry, if there is such an entry.
template <class T>
bool change(T& values, std::size_t entry) {
  if constexpr (requires {
                  values.x.data();
                  values.set(entry, Vec3{});
                }) {
    if (values.z.size() <= entry) return false;
    values.z[entry] += 1;
    return true;
  } else if constexpr (requires { requires std::is_arithmetic_v<typename T::value_type>; }) {
    if (values.size() <= entry) return false;
    values[entry] = static_cast<typename T::value_type>(values[entry] + 1);
    return true;
  } else {
    return false;
  }
}

/// Changes field after field; returns how many are hashed.
template <class Model, class State>
int check_hash(const Model& model, const State& rest, std::size_t entry) {
  const std::uint64_t hash = state_hash(model, rest);
  int fields = 0, hashed = 0;
  visit_fields(rest, [&](const Field&, const auto&) { fields++; });
  for (int n = 0; n < fields; n++) {
    State state = rest;
    int at = 0;
    bool changed = false;
    Field name{};
    visit_fields(state, [&](const Field& field, auto& values) {
      if (at++ == n) name = field, changed = change(values, entry);
    });
    if (!changed) continue;
    EXPECT_EQ(state_hash(model, state) != hash, bool(name.use & kHashed)) << name.name;
    hashed += bool(name.use & kHashed);
  }
  return hashed;
}

TEST(Fields, AFieldOfALatticeIsInItsHashExactlyIfItSaysSo) {
  const lattice::Model model = lattice::block_model({.size = {5, 4, 3}}, {});
  const int slot = node_slot(model.lattice, {2, 1, 1});
  EXPECT_EQ(check_hash(model, lattice::make_state(model), std::size_t(slot)), 4);
}

TEST(Fields, AFieldOfAClothIsInItsHashExactlyIfItSaysSo) {
  const cloth::Model model = cloth::must_build(cloth::flat_sheet(6), {.collision = {.thickness = 0.004}});
  EXPECT_EQ(check_hash(model, cloth::make_state(model), 11), 2);
}

TEST(Fields, MemoryGrowsByWhatAFieldGrows) {
  const lattice::Model model = lattice::block_model({.size = {5, 4, 3}}, {});
  lattice::State state = lattice::make_state(model);
  const std::size_t before = lattice::memory_bytes(model, state);
  state.cut_edges.reserve(10);
  EXPECT_EQ(lattice::memory_bytes(model, state), before + 10 * sizeof(lattice::CutEdge));
  const cloth::Model sheet = cloth::must_build(cloth::flat_sheet(6), {.collision = {.thickness = 0.004}});
  cloth::State lying = cloth::make_state(sheet);
  const std::size_t less = cloth::memory_bytes(sheet, lying);
  lying.spatial_hash.index.reserve(100);  // a field within a field
  lying.contacts.found.resize(2);
  lying.contacts.found[1].reserve(3);
  EXPECT_EQ(cloth::memory_bytes(sheet, lying), less + 100 * sizeof(int) + 3 * sizeof(cloth::Contact));
}

TEST(Fields, TissuesAreBinnedAtTheSameDensitiesByALatticeAndBySummaries) {
  const lattice::TissueParams tissue;
  EXPECT_EQ(tissue.air_max, kAirBelow);
  EXPECT_EQ(tissue.fat_max, kFatBelow);
  EXPECT_EQ(tissue.bone_min, kBoneFrom);
}

}  // namespace
}  // namespace turgor

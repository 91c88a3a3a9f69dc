// Consistency of visit_fields with the hashes and memory sizes of states.
#include "turgor/models/cloth/model/fields.hpp"

#include "tests/models/cloth/sheets.hpp"
#include "tests/models/lattice/block_body.hpp"
#include "turgor/core/field.hpp"
#include "turgor/geometry/label_measures.hpp"
#include "turgor/models/lattice/lattice.hpp"
#include "turgor/models/lattice/model/fields.hpp"

namespace turgor {
namespace {

/// Adds one to an entry; returns whether the entry exists.
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

/// Changes one field after the other; returns the number of hashed ones.
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

// A lattice field enters the hash exactly if it is declared as hashed.
TEST(Fields, LatticeHashCoversDeclaredFields) {
  const lattice::Model model = lattice::block_model({.size = {5, 4, 3}}, {});
  const int slot = node_slot(model.anatomy.lattice, {2, 1, 1});
  EXPECT_EQ(check_hash(model, lattice::make_state(model), std::size_t(slot)), 4);
}

// A cloth field enters the hash exactly if it is declared as hashed.
TEST(Fields, ClothHashCoversDeclaredFields) {
  const cloth::Model model = cloth::must_build(cloth::flat_sheet(6), {.collision = {.thickness = 0.004}});
  EXPECT_EQ(check_hash(model, cloth::make_state(model), 11), 2);
}

// The memory grows by the capacity of the fields, nested fields included.
TEST(Fields, MemoryCountsFieldCapacity) {
  const lattice::Model model = lattice::block_model({.size = {5, 4, 3}}, {});
  lattice::State state = lattice::make_state(model);
  const std::size_t before = lattice::memory_bytes(model, state);
  state.cuts.edges.reserve(10);
  EXPECT_EQ(lattice::memory_bytes(model, state), before + 10 * sizeof(lattice::CutEdge));
  const cloth::Model sheet = cloth::must_build(cloth::flat_sheet(6), {.collision = {.thickness = 0.004}});
  cloth::State lying = cloth::make_state(sheet);
  const std::size_t less = cloth::memory_bytes(sheet, lying);
  lying.spatial_hash.index.reserve(100);  // a nested field
  lying.contacts.candidates.resize(2);
  lying.contacts.candidates[1].reserve(3);
  EXPECT_EQ(cloth::memory_bytes(sheet, lying), less + 100 * sizeof(int) + 3 * sizeof(cloth::Contact));
}

// The lattice and the summaries of CTs use the same density thresholds.
TEST(Fields, TissueThresholdsMatchSummaries) {
  const lattice::TissueParams tissue;
  EXPECT_EQ(tissue.air_max, kAirBelow);
  EXPECT_EQ(tissue.fat_max, kFatBelow);
  EXPECT_EQ(tissue.bone_min, kBoneFrom);
}

}  // namespace
}  // namespace turgor

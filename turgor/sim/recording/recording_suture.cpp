#include "turgor/sim/recording/recording_suture.hpp"

#include <cmath>

#include <fmt/format.h>

namespace turgor {

namespace {

constexpr std::size_t kNumbers = 5;  // of a stitch: length, length before, tension, multiplier, end

std::string suture_group(const std::string& group, const Suture& suture) {
  return fmt::format("{}/sutures/{}/", group, suture.scene.name);
}

}  // namespace

Status write_suture(Hdf5File& file, const std::string& group, const Suture& suture) {
  std::vector<std::int32_t> phases;
  std::vector<double> stitches, walls;
  if (suture.closure) {
    for (const lattice::Stitch& s : suture.closure->stitches) {
      phases.push_back(int(s.phase));
      stitches.insert(stitches.end(), {s.length, s.before, s.tension, s.multiplier, s.ended});
    }
    for (const lattice::WallPair& pair : suture.closure->walls)
      walls.insert(walls.end(), {pair.force, pair.multiplier});
  }
  return Writing(file, suture_group(group, suture))
      .array("phase", phases)
      .array("stitches", stitches, kNumbers, "m, m, N, N, s")
      .array("walls", walls, 2, "N, N")
      .status();
}

Status read_suture_state(const Hdf5File& file, const std::string& group, const World& world, Suture& suture) {
  // datasets
  constexpr std::size_t kMostStitches = 1 << 20;
  Reading reading(file, suture_group(group, suture));
  const std::size_t count = reading.count("phase", kMostStitches);
  const auto phases = reading.array<std::int32_t>("phase", count);
  const auto stitches = reading.array<double>("stitches", kNumbers * count);
  const auto walls = reading.array<double>("walls", reading.count("walls", 2 * kMostStitches));
  suture.closure.reset();
  if (!reading.status() || count == 0) return reading.status();

  // stitches on the wound
  const Cut& cut = world.cuts[std::size_t(suture.scene.incision)];
  const LatticeBody& body = world.lattice_bodies[std::size_t(suture.scene.body)];
  if (const Status laid = advance_suture(body, cut, suture.scene.pull.start, suture); !laid) return laid;
  // another suture of the wound may have had its walls
  if (suture.closure && 2 * suture.closure->walls.size() != walls.size()) remove_walls(*suture.closure);
  if (!suture.closure || suture.closure->stitches.size() != count ||
      2 * suture.closure->walls.size() != walls.size()) {
    reading.fail("phase", "expected the stitches of the scene");
    return reading.status();
  }

  // state
  for (std::size_t n = 0; n < count; n++) {
    lattice::Stitch& s = suture.closure->stitches[n];
    const double* numbers = &stitches[kNumbers * n];
    if (phases[n] < 0 || phases[n] > int(lattice::StitchPhase::kBroken) || !std::isfinite(numbers[2]))
      reading.fail("phase", fmt::format("row {}: expected a state from 0 to 4 and finite numbers", n + 1));
    s.phase = lattice::StitchPhase(phases[n]);
    s.length = numbers[0], s.before = numbers[1], s.tension = numbers[2], s.multiplier = numbers[3],
    s.ended = numbers[4];
  }
  if (suture.closure->is_running) join_stitches(*suture.closure);
  for (std::size_t n = 0; n < suture.closure->walls.size(); n++)
    suture.closure->walls[n].force = walls[2 * n], suture.closure->walls[n].multiplier = walls[2 * n + 1];
  return reading.status();
}

}  // namespace turgor

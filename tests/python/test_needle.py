"""A needle that Python leads: what it feels, its report, and a hand that begins inside."""
import unittest

import numpy as np

import turgor
from scenes import PAD

TOP, ENTRY, FRICTION = 0.03, 0.328, 4  # surface of the pad [m], force of a puncture [N], of the shaft [N/m]
NEEDLE = PAD.replace("shape = { sphere = 0.006 }", f"shape = {{ needle = 0.06, diameter = 0.001, shaft_friction = {FRICTION}, spreading = 0 }}")


def stroke(ticks):
    """Poses (ticks, 1, 7) of a needle that goes 15 mm into the pad at 50 mm/s, and out again."""
    time = 1e-3 * (1 + np.arange(ticks))
    depth = 0.015 - np.abs(0.016 - 0.05 * time)
    poses = np.zeros((ticks, 1, 7))
    poses[:, 0, :3] = np.stack([np.full(ticks, 0.031), np.full(ticks, 0.028), TOP - depth], 1)
    poses[:, 0, 3] = 1
    return poses


class Needle(unittest.TestCase):
    # The force rises until the tip punctures, grows with the length inside, and holds the needle back as it leaves.
    def test_stroke_punctures_and_is_reported(self):
        world = turgor.World(text=NEEDLE)
        poses = stroke(660)
        along, depth = world.tick(poses)[:, 0, 2], TOP - poses[:, 0, 2]
        self.assertAlmostEqual(along[:150].max(), ENTRY, delta=0.05 * ENTRY)
        for ticks in (slice(200, 300), slice(400, 500)):
            growth = np.polyfit(depth[ticks], np.abs(along[ticks]), 1)[0]
            self.assertAlmostEqual(growth / FRICTION, 1, delta=0.1)
        self.assertLess(along[400:500].max(), 0)
        np.testing.assert_allclose(along[-10:], 0, atol=1e-9)
        needle = world.report()["tools"][0]["needle"]
        self.assertEqual(needle["punctures"], 1)
        self.assertGreater(needle["inserted_max_mm"], 8)
        self.assertLess(abs(needle["work"]["error_percent"]), 1)

    # A copy that is made while the needle is in goes on with the same bits.
    def test_copy_with_inserted_needle_has_same_bits(self):
        world = turgor.World(text=NEEDLE, threads=1)
        poses = stroke(500)
        world.tick(poses[:260])
        other = world.copy()
        np.testing.assert_array_equal(world.tick(poses[260:]), other.tick(poses[260:]))
        self.assertEqual(world.state_hash, other.state_hash)

    def test_path_that_starts_inside_is_refused(self):
        with self.assertRaisesRegex(turgor.Error, "expected a needle that starts outside of pad, found its tip 0.01 m below"):
            turgor.World(text=NEEDLE, set={"tool.finger.path": [[0, 0.03, 0.03, 0.02], [1, 0.03, 0.03, 0.01]]})


if __name__ == "__main__":
    unittest.main()

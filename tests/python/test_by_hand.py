"""Cuts and stitches by hand: bits of a scene, copies, refusals."""
import pathlib
import tempfile
import unittest

import numpy as np

import turgor
from scenes import PAD

BLOCK = """[world]
duration = 2
frame_rate = 50
[body.block]
model = "lattice"
ct = "given in memory"
block = 2
fixed = "bone"
"""
LINE = [[0.002, -0.02, -0.03], [0.002, -0.02, 0.03]]
THREAD = [[-0.010, -0.019, 0.004], [-0.010, -0.015, 0.004], [0.014, -0.015, 0.004], [0.014, -0.019, 0.004]]
SEWN = BLOCK + f"""[incision.cut]
body = "block"
from = {LINE[0]}
to = {LINE[1]}
depth = 0.012
start = 0.04
duration = 0.04
[suture.one]
wound = "cut"
through = {THREAD}
tension = 0.5
start = 0.18
duration = 0.2
"""

EXCISED = BLOCK + """[excision.mole]
body = "block"
center = [0.002, -0.02, 0.001]
length = 0.05
width = 0.03
depth = 0.012
start = 0.02
duration = 0.04
[suture.row]
wound = "mole"
bite = 0.008
depth = 0.003
spacing = 0.01
start = 0.1
duration = 0.3
"""


def block(text=BLOCK, threads=1):
    """World of 40 mm of fat on a slab of bone."""
    hu = np.full((40, 24, 40), -1000, np.int16)
    hu[4:36, 4:20, 4:36] = 1000
    hu[4:36, 4:14, 4:36] = -100
    ct = turgor.Volume(hu, spacing=(4e-3, 4e-3, 4e-3), origin=(-0.078, -0.036, -0.078))
    return turgor.World(text=text, volumes={"block": ct}, threads=threads)


class ByHand(unittest.TestCase):
    # A cut and a stitch by hand have the bits of those of a scene, and a copy of the world keeps them.
    def test_bits_of_scene(self):
        scene = block(SEWN)
        scene.step(30)
        world = block(threads=2)
        world.step(2)
        self.assertEqual(world.cut("block", LINE, 0.012, duration=0.04, name="cut"), "cut")
        world.step(6)
        uncut = world.get_state()
        self.assertEqual(world.stitch("block", THREAD, wound="cut", tension=0.5, duration=0.2), "hand-1")
        copy = world.copy()
        world.step(22)
        self.assertEqual(world.state_hash, scene.state_hash)
        copy.step(22)
        self.assertEqual(copy.state_hash, scene.state_hash)
        self.assertEqual(world.report()["sutures"][0]["wound"], "cut")
        # tightened, and measured frame by frame
        before = world.measures("cut")["gape_max_m"][-1]
        world.tighten("hand-1", 1.0, 0.1)
        world.step(20)
        self.assertLess(world.measures("cut")["gape_max_m"][-1], before)
        self.assertAlmostEqual(world.measures("hand-1")["tension_max_N"][-1], 1, delta=0.2)
        # the state before the stitch has none
        world.set_state(uncut)
        self.assertEqual(world.report().get("sutures", []), [])

    # A file of a world continues with the same bits in a fresh world; files of other worlds change nothing.
    def test_saved_world_continues(self):
        world, fresh = block(), block(threads=2)
        world.cut("block", LINE, 0.012, duration=0.04, name="cut")
        world.step(8)
        world.stitch("block", THREAD, wound="cut", tension=0.5, duration=0.2)
        world.step(6)
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "world.state")
            world.save(file)
            fresh.step(3)
            fresh.load(file)
            self.assertEqual(fresh.state_hash, world.state_hash)
            for one in (world, fresh):
                one.step(10)
            self.assertEqual(fresh.state_hash, world.state_hash)
            self.assertEqual(fresh.measures("hand-1")["tension_max_N"].tolist(), world.measures("hand-1")["tension_max_N"].tolist())
            # another scene, no file, a damaged one
            other = block(SEWN)
            before = other.state_hash
            for path in (file, pathlib.Path(folder, "none.state")):
                with self.assertRaises(turgor.Error):
                    other.load(path)
            file.write_bytes(file.read_bytes()[:1000])
            with self.assertRaises(turgor.Error):
                fresh.load(file)
            self.assertEqual(other.state_hash, before)

    # Restored states and files replace a cut by another one of as many edges: points and triangles are those of the new one.
    def test_surface_is_that_of_restored_cuts(self):
        def cut_at(world, x):
            world.cut("block", [[x, -0.02, -0.03], [x, -0.02, 0.03]], 0.012, duration=0)
            world.step()
            return world["block"].rest_points, world["block"].triangles

        world = block()
        state = world.get_state()
        first = cut_at(world, 0.002)
        expected = cut_at(block(), 0.010)
        self.assertFalse(np.array_equal(first[0], expected[0]))
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "world.state")
            for restore in (lambda: world.set_state(state), lambda: world.load(file)):
                restore()
                if not file.exists():
                    world.save(file)
                for found, wanted in zip(cut_at(world, 0.010), expected):
                    np.testing.assert_array_equal(found, wanted)
                restore()
                cut_at(world, 0.002)

    # A wound and a stitch with the default name have both their measures.
    def test_measures_of_equal_names(self):
        world = block()
        self.assertEqual(world.cut("block", LINE, 0.012, duration=0.04), "hand-1")
        world.step(8)
        self.assertEqual(world.stitch("block", THREAD, tension=0.5, duration=0.2), "hand-1")
        world.step(4)
        self.assertEqual(list(world.measures()), ["hand-1", "suture.hand-1"])
        self.assertGreater(world.measures("hand-1")["opening_area_m2"][-1], 0)
        self.assertGreater(world.measures("suture.hand-1")["tension_max_N"][-1], 0)

    # An excision of a scene is weighed, the row that closes it is measured, and a copy has the same bits.
    def test_excision_is_weighed_and_closed(self):
        world = block(EXCISED, threads=1)
        world.step(12)
        copy = world.copy()
        world.step(18)
        copy.step(18)
        self.assertEqual(world.state_hash, copy.state_hash)
        report = world.report()
        specimen, suture = report["wounds"][0]["specimen"], report["sutures"][0]
        self.assertAlmostEqual(specimen["mass_g"], 0.9 * specimen["volume_ml"], delta=1e-3)  # fat of -100 HU
        self.assertEqual(suture["stitches_bearing"], 5)
        gape = world.measures("mole")["gape_max_m"]
        self.assertLess(gape[-1], gape.max())
        self.assertAlmostEqual(world.measures("row")["closing_force_N"][-1], suture["closing_force_N"], delta=1e-4)

    # What cannot be cut or sewn is refused with the reason.
    def test_refusals(self):
        world = block()
        for call, words in (
                (lambda: world.cut("block", LINE, -1), "expected a depth above 0 and below 1 m, found -1"),
                (lambda: world.cut("block", LINE, 0.01, name="a b"), "found a b"),
                (lambda: world.cut("block", [[0, 1, 0], [0.1, 1, 0]], 0.01), "skin"),
                (lambda: world.stitch("block", THREAD), "both sides of a complete cut"),
                (lambda: world.stitch("block", THREAD, thread="rope"), "unknown thread rope"),
                (lambda: world.stitch("block", THREAD, wound="cut"), "no wound cut"),
                (lambda: world.tighten("hand-1"), "no stitch by hand hand-1"),
                (lambda: turgor.World(text=PAD).cut("pad", LINE, 0.01), 'model = "sfem"')):
            with self.subTest(words), self.assertRaisesRegex(turgor.Error, words):
                call()
        with self.assertRaisesRegex(KeyError, "no body liver"):
            world.cut("liver", LINE, 0.01)
        with self.assertRaisesRegex(ValueError, r"points \(n, 3\)"):
            world.stitch("block", [0, 1, 2])


if __name__ == "__main__":
    unittest.main()

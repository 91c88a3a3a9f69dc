"""Forces of attachments and of contacts between bodies in Python, by the snippet of docs/organs-in-contact.md."""
import unittest

import numpy
import turgor
from test_documents import blocks_of

G = 9.81  # [m/s²]


def block(name, corner, size, count, fixed):
    return (f"[body.{name}]\nmodel = \"sfem\"\nblock = {{ corner = {corner}, size = {size}, count = {count} }}\n"
            f"fixed = \"{fixed}\"\nyoung = 2e4\npoisson = 0.3\ndensity = 1000\ncache = false\n")


# A stone of 24 g hangs from the ground, a tile of 12 g lies on a base.
SCENE = (f"[world]\ngravity = [0, 0, -{G}]\nduration = 5\n"
         + block("stone", [0, 0, 0.2], [0.04, 0.03, 0.02], [4, 3, 2], "none")
         + block("base", [0, 0, 0], [0.06, 0.06, 0.02], [6, 6, 2], "bottom")
         + block("tile", [0.015, 0.02, 0.02], [0.03, 0.02, 0.02], [3, 2, 2], "none")
         + "[attachment.bed]\nbetween = [\"stone\", \"ground\"]\nbox = [[-1, -1, 0.2199], [1, 1, 1]]\nstiffness = 40\n"
         + "[contact.floor]\nbetween = [\"tile\", \"base\"]\nfriction = 0.1\n")


class Organs(unittest.TestCase):
    def test_report_has_weights(self):
        world = turgor.World(text=SCENE)
        world.step(300)
        names = {"world": world}
        exec(next(b for b in blocks_of("docs/organs-in-contact.md") if "world.report()" in b), names)  # pylint: disable=exec-used
        bed, floor = names["report"]["attachments"][0], names["report"]["body_contacts"][0]
        self.assertAlmostEqual(bed["force_N"], 0.024 * G, delta=1e-3 * 0.024 * G)
        self.assertEqual(bed["condition"], "intact")
        self.assertEqual(floor["between"], "tile, base")
        self.assertAlmostEqual(floor["force_z_N"], 0.012 * G, delta=1e-3 * 0.012 * G)
        self.assertEqual(floor["series"][-1][floor["series_columns"].index("force_z_N")], floor["force_z_N"])
        # forces by frame, on the first body of `between`
        forces = world.measures("bed")["force_N"]
        self.assertEqual(forces.shape, (300, 3))
        numpy.testing.assert_allclose(forces[-1], [0, 0, 0.024 * G], atol=1e-3 * 0.024 * G)


if __name__ == "__main__":
    unittest.main()

"""Snippets of docs/python.md, as printed."""
import os
import pathlib
import re
import unittest

import numpy
import turgor

ROOT = pathlib.Path(__file__).resolve().parents[2]


def blocks_of(page):
    """Blocks of Python code of a page."""
    return re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), re.S)


class Documents(unittest.TestCase):
    def test_hand_presses_liver(self):
        hand = next(block for block in blocks_of("docs/python.md") if "world.tick(poses" in block)
        before = os.getcwd()
        os.chdir(ROOT)
        try:
            names = {"numpy": numpy, "world": turgor.World("scenes/palpation.toml")}
            exec(hand, names)  # pylint: disable=exec-used
        finally:
            os.chdir(before)
        force = numpy.linalg.norm(names["wrench"][:, 0, :3], axis=1)
        self.assertLess(force[0], 0.01)
        self.assertGreater(force.max(), 0.1)


if __name__ == "__main__":
    unittest.main()

"""Types of the Python module as mypy sees them, its texts, and refused arguments."""
import ast
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import turgor
from scenes import CLOTH, PAD

try:
    import mypy
except ImportError:
    mypy = None

try:
    import pandas
except ImportError:
    pandas = None

SNIPPET = """
import turgor
world = turgor.World("s.toml", set={"body.a.young": 5e3}, threads=2)
for moment in world.run(every=0.1):
    reveal_type(moment)
reveal_type(world.forces("finger")["force_N"])
reveal_type(world.forces("finger")["contacts"])
reveal_type(world.measures("midline")["gape_max_m"])
reveal_type(world["liver"].displacement)
reveal_type(world["liver"].triangles)
reveal_type(world["liver"].volume().samples)
reveal_type(world.tick([[[0.0] * 7]]))
reveal_type(world.report())
reveal_type(world.state_hash)
world.step("three")
"""
FLOAT64 = r"ndarray\[.*(_64Bit|float64)"
REVEALED = (r"turgor\.world\.World", FLOAT64, r"ndarray\[.*(_32Bit|int32|intc)", FLOAT64, r"ndarray\[.*dtype\[.*floating\[.*_32Bit.*\]\]\]|ndarray\[.*float32",
            r"ndarray\[.*int", r"ndarray\[.*dtype\[Any\]\]", FLOAT64, r"dict\[.*str, Any\]", r"str")


def texts_by_name(stub):
    """Arguments and docstrings of classes, functions and properties by name."""
    found = {}
    tree = ast.parse(stub.read_text())
    for outer in tree.body:
        for node in [outer, *getattr(outer, "body", [])]:
            if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
                name = node.name if node is outer else f"{outer.name}.{node.name}"
                arguments = [a.arg for a in node.args.args] if isinstance(node, ast.FunctionDef) else []
                found.setdefault(name, []).append((arguments, ast.get_docstring(node)))
    return found


class Types(unittest.TestCase):
    # mypy knows the types of worlds, forces and fields, and finds a wrong argument.
    @unittest.skipUnless(mypy, "mypy is not installed")
    def test_mypy_sees_types(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "snippet.py"
            file.write_text(SNIPPET)
            done = subprocess.run([sys.executable, "-m", "mypy", "--cache-dir", os.devnull, str(file)], capture_output=True, text=True,
                                  env={**os.environ, "MYPYPATH": os.path.dirname(os.path.dirname(turgor.__file__))})
        found = re.findall(r'Revealed type is "(.*)"', done.stdout)
        self.assertEqual(len(found), len(REVEALED), done.stdout + done.stderr)
        for expected, one in zip(REVEALED, found):
            self.assertRegex(one, expected)
        self.assertRegex(done.stdout, r'error: Argument 1 to "step".* has incompatible type "str"; expected "int"')

    # The types and texts in the source tree, from which the documentation is made, are those of the engine.
    def test_stub_in_source_is_current(self):
        source, built = pathlib.Path(__file__).parents[2] / "python/turgor/_turgor.pyi", pathlib.Path(turgor.__file__).parent / "_turgor.pyi"
        self.assertEqual(texts_by_name(source), texts_by_name(built), f"copy {built} to {source}")

    # Texts of objects say what they are.
    def test_texts_say_what_objects_are(self):
        world = turgor.World(text=PAD)
        self.assertRegex(repr(world), r"^<turgor\.World .*scene\.toml: 0 of [\d.]+ s, bodies pad, tools finger>$")
        self.assertEqual(repr(world["pad"]), "<turgor.Body pad: sfem>")
        self.assertEqual(repr(turgor.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])), "Mesh(3 points, 1 triangles)")

    # A frame names every component of a vector and of a quaternion, with the unit at the end.
    @unittest.skipUnless(pandas, "pandas is not installed")
    def test_frames_name_components(self):
        world = turgor.World({"body": {"stone": {"model": "rigid", "shape": {"sphere": 0.01}, "mass": 0.1, "spin": [0, 0, 3]}}})
        world.step(2)
        motion = world.measures("stone")
        frame = motion.frame()
        self.assertEqual(list(frame.columns), ["time_s", "center_x_m", "center_y_m", "center_z_m", "rotation_w", "rotation_x", "rotation_y",
                                               "rotation_z", "velocity_x_m_per_s", "velocity_y_m_per_s", "velocity_z_m_per_s",
                                               "spin_x_rad_per_s", "spin_y_rad_per_s", "spin_z_rad_per_s"])
        np.testing.assert_array_equal(frame["rotation_z"], motion["rotation"][:, 3])

    # Numbers and shapes that make no sense raise a ValueError that names the argument.
    def test_senseless_arguments_are_refused(self):
        world = turgor.World(text=PAD)
        for call, sentence in ((lambda: world.step(-1), "step: expected frames of at least 0, found -1"),
                               (lambda: world.run(seconds=-1), "run: expected seconds of at least 0, found -1"),
                               (lambda: world.run(every=0), "run: expected every above 0 s, found 0"),
                               (lambda: world.drive("finger", [0, 0.03, 0.03]), r"drive: expected rows \(n, 4\), \(n, 5\) or \(n, 9\), found an array of \(3,\)"),
                               (lambda: world.tick(np.zeros((2, 7))), r"tick: expected poses \(ticks, tools, 7\), found an array of \(2, 7\)")):
            with self.assertRaisesRegex(ValueError, sentence):
                call()
        with self.assertRaises(TypeError):
            world.step(1.5)
        with self.assertRaisesRegex(KeyError, "has the name pad; known are none"):
            world.measures("pad")
        with self.assertRaisesRegex(KeyError, "has the name sheeet; known are sheet"):
            turgor.World(text=CLOTH).measures("sheeet")
        self.assertEqual(turgor.World(text=CLOTH).frame, 0)


if __name__ == "__main__":
    unittest.main()

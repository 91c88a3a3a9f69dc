"""Properties of the full wheel: it draws, reads every format, and has the program with its window."""
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import turgor

PACKAGE = pathlib.Path(turgor.__file__).parent
SMALL = {"world": {"duration": 0.1, "frame_rate": 50},
         "body": {"pad": {"model": "sfem", "block": {"size": [0.06, 0.06, 0.03], "count": [6, 6, 3]}, "fixed": "bottom", "young": 5e3,
                          "poisson": 0.4}},
         "tool": {"finger": {"body": "pad", "shape": {"sphere": 0.006}, "path": [[0, 0.03, 0.03, 0.034]]}}}


class FullWheel(unittest.TestCase):
    def run_program(self, *arguments):
        return subprocess.run([pathlib.Path(sys.executable).parent / "turgor", *map(str, arguments)], capture_output=True, text=True)

    # The module draws pictures, with the font of the wheel if the system has none.
    def test_module_draws(self):
        self.assertIn("site-packages", turgor.__file__)
        with tempfile.TemporaryDirectory() as folder:
            turgor.run(SMALL, out=pathlib.Path(folder) / "out")
            self.assertTrue(list((pathlib.Path(folder) / "out").glob("*.png")))

    # `turgor` is on the path of the environment; its window and measurements are there too.
    def test_program_runs(self):
        version = self.run_program("--version")
        self.assertEqual((version.returncode, version.stdout.strip()), (0, f"turgor {turgor.__version__}"), version.stderr)
        for command in ("view", "bench", "validate"):
            self.assertEqual(self.run_program(command, "--help").returncode, 0, command)
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "out"
            done = self.run_program("run", PACKAGE / "share/turgor/scenes/press-sheet.toml", "--set", "world.duration=0.1", "--out", out)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertTrue((out / "report.html").exists())

    # Libraries come with the wheel, apart from the drivers of the display, and each has its license.
    def test_libraries_are_included(self):
        needs = subprocess.run(["ldd", PACKAGE / "bin/turgor-view"], capture_output=True, text=True).stdout
        self.assertNotIn("not found", needs)
        for library in ("libgdcmCommon", "libhdf5", "libtbb", "libfmt"):
            line = next(line for line in needs.splitlines() if library in line)
            self.assertIn("turgor.libs", line)
        licenses = {file.name for file in next(PACKAGE.parent.glob("turgor-*.dist-info")).glob("licenses/*")}
        self.assertTrue({"LICENSE", "libgdcm3.0.txt", "libtbb12.txt", "nanobind.txt", "robin-map.txt"} <= licenses, licenses)
        self.assertTrue({"libeigen3-dev.txt", "libcli11-dev.txt", "libimgui-dev.txt"} <= licenses, licenses)  # compiled in
        self.assertTrue({"fonts-dejavu-core.txt", "libjs-three.txt"} <= licenses, licenses)
        for library in PACKAGE.parent.glob("turgor.libs/*"):
            name = re.sub(r"-[0-9a-f]{8}(?=\.)", "", library.name)  # auditwheel's hash
            owners = subprocess.run(["dpkg", "-S", f"*-linux-gnu/{name}"], capture_output=True, text=True).stdout.splitlines()
            self.assertTrue(any(f"{owner.split(':')[0]}.txt" in licenses for owner in owners), (name, owners))

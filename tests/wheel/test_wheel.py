"""Properties of the wheel: the features that it lacks, and their error messages."""
import importlib.metadata
import os
import pathlib
import platform
import re
import subprocess
import sys
import tempfile
import unittest

import numpy as np

import turgor
from turgor.engine import NEEDS, processor_flags

ENGINES = pathlib.Path(turgor.__file__).parent / "engines"
SLICER = pathlib.Path(__file__).resolve().parents[2] / "slicer/Turgor/Turgor"
sys.path.insert(0, str(SLICER))
from TurgorLib.cut import Cut, Cutter, CutOptions  # noqa: E402

PAD = {"world": {"duration": 0.2, "frame_rate": 50},
       "body": {"pad": {"model": "sfem", "block": {"size": [0.06, 0.06, 0.03], "count": [6, 6, 3]}, "fixed": "bottom", "young": 5e3,
                        "poisson": 0.4}},
       "tool": {"finger": {"body": "pad", "shape": {"sphere": 0.006}, "path": [[0, 0.03, 0.03, 0.034]]}}}


def block(file):
    return {"body": {"block": {"model": "lattice", "ct": file, "block": 2, "fixed": ["ends"], "skin": {"tension": 0}}}}


class Wheel(unittest.TestCase):
    # The installed wheel loads no libraries for graphics or codecs.
    def test_loads_no_graphics_and_no_codecs(self):
        self.assertIn("site-packages", turgor.__file__)
        world = turgor.World(PAD)
        world.step(5)
        loaded = pathlib.Path("/proc/self/maps").read_text()
        for name in ("libGL", "libEGL", "libepoxy", "libhdf5", "libgdcm", "libcurl"):
            self.assertNotIn(name, loaded)
        self.assertIn("turgor.libs", loaded)

    # Included libraries and code that is compiled in have their licenses.
    def test_has_licenses(self):
        files = importlib.metadata.files("turgor")
        licenses = {file.name for file in files if "licenses" in file.parts}
        self.assertTrue({"LICENSE", "libeigen3-dev.txt", "nlohmann-json3-dev.txt", "nanobind.txt", "robin-map.txt"} <= licenses, licenses)
        libraries = [file.name for file in files if file.parts[0] == "turgor.libs"]
        self.assertTrue(libraries)
        for library in libraries:
            name = library.partition("-")[0]  # before auditwheel's hash
            self.assertTrue(any(file.startswith(name) for file in licenses), (name, licenses))

    # The wheel is tagged for glibc 2.34 or older.
    def test_wheel_supports_glibc_2_34(self):
        if platform.freedesktop_os_release().get("VERSION_CODENAME") != "bookworm":
            self.skipTest("the tag depends on the system that built the wheel")
        tags = [line for line in importlib.metadata.distribution("turgor").read_text("WHEEL").splitlines() if line.startswith("Tag:")]
        self.assertEqual(len(tags), 1)
        self.assertLessEqual(int(re.search(r"manylinux_2_(\d+)_x86_64$", tags[0]).group(1)), 34)

    # Report and module name the loaded engine.
    def test_report_and_module_name_engine(self):
        flags = processor_flags()
        self.assertLessEqual(NEEDS[turgor.instructions.rpartition("-")[2]], flags)
        self.assertEqual(turgor.World(PAD).report()["machine"]["instructions"], turgor.instructions)
        forced = os.environ.get("TURGOR_ENGINE")
        if forced:
            self.assertEqual(turgor.instructions, f"x86-64-{forced}")

    # The engine is chosen by the processor, forced by a variable, or rejected.
    @unittest.skipUnless(ENGINES.is_dir(), "a wheel with one engine")
    def test_engine_is_chosen_forced_or_rejected(self):
        can = [level for level in NEEDS if NEEDS[level] <= processor_flags()]
        for level in (None, *NEEDS):
            environment = {key: value for key, value in os.environ.items() if key != "TURGOR_ENGINE"} | ({"TURGOR_ENGINE": level} if level else {})
            done = subprocess.run([sys.executable, "-c", "import turgor; print(turgor.instructions)"], env=environment, capture_output=True, text=True)
            if level in can or not level:
                self.assertEqual(done.stdout.strip(), f"x86-64-{level or can[-1]}", done.stderr)
            else:
                self.assertIn(f"expected a processor of x86-64-{level}, found one without", done.stderr)

    # A cache that cannot be used is not an error.
    def test_unusable_cache_is_not_an_error(self):
        with tempfile.TemporaryDirectory() as folder:
            world = turgor.World(PAD, set={"body.pad.cache": folder})
            world.step(5)
        again = turgor.World(PAD, set={"body.pad.cache": False})
        again.step(5)
        self.assertEqual(world.state_hash, again.state_hash)
        self.assertGreater(world.forces("finger")["force_N"][-1, 2], 0.005)

    # A run into a folder fails with a message, because the wheel draws no pictures.
    def test_run_into_folder_is_explained(self):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "out"
            with self.assertRaisesRegex(turgor.Error, "draws no pictures"):
                turgor.run(PAD, out=out)
            self.assertFalse(out.exists())

    # The wheel reads NIfTI files without other packages.
    def test_reads_nifti_without_packages(self):
        hu = np.full((16, 16, 16), -1000, dtype=np.int16)
        hu[3:13, 3:13, 3:13] = 40
        header = np.zeros(352, dtype=np.uint8)
        header[0:4] = np.frombuffer(np.int32(348).tobytes(), np.uint8)
        header[40:56] = np.frombuffer(np.array([3, 16, 16, 16, 1, 1, 1, 1], dtype=np.int16).tobytes(), np.uint8)
        header[70:74] = np.frombuffer(np.array([4, 16], dtype=np.int16).tobytes(), np.uint8)
        header[76:108] = np.frombuffer(np.array([1, 3, 3, 3, 1, 1, 1, 1], dtype=np.float32).tobytes(), np.uint8)
        header[108:112] = np.frombuffer(np.float32(352).tobytes(), np.uint8)
        header[123] = 2  # mm
        header[254:256] = np.frombuffer(np.int16(1).tobytes(), np.uint8)
        rows = np.array([[3, 0, 0, 0], [0, 3, 0, 0], [0, 0, 3, 0]], dtype=np.float32)
        header[280:328] = np.frombuffer(rows.tobytes(), np.uint8)
        header[344:348] = np.frombuffer(b"n+1\0", np.uint8)
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "block.nii"
            file.write_bytes(header.tobytes() + hu.tobytes())
            from_file = turgor.World(block(file))
        volume = from_file["block"].volume()
        self.assertEqual(sorted(np.unique(volume.samples).tolist()), [-1000, 40])
        np.testing.assert_allclose(volume.spacing, 3e-3)


    # The wheel runs the worker of the 3D Slicer module.
    def test_cuts_for_3d_slicer(self):
        samples = np.full((24, 24, 24), -1000, dtype=np.int16)
        samples[2:22, 2:22, :] = 40
        to_ras = np.diag([-3.0, -3.0, 3.0, 1.0])
        line = np.array([[-35.0, -6, 20], [-35, -6, 50]])  # on the front
        python = Cutter(lambda folder: [sys.executable, str(SLICER / "TurgorLib/worker.py"), str(folder)], dict(os.environ))
        cut = Cut(python, samples, to_ras, line, CutOptions(depth=15, step=6, seconds=0.3))
        cut.process.wait()
        opened = cut.opened()
        self.assertEqual(opened.samples.shape, samples.shape)
        self.assertGreater(dict((name, value) for name, value, _ in opened.measures)["gape, largest"], 0.5)
        wall = opened.points[opened.wound].reshape(-1, 3)
        self.assertGreater(len(wall), 10)
        self.assertLess(np.abs(wall[:, 0] + 35).max(), 15)


if __name__ == "__main__":
    unittest.main()

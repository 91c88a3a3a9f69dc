"""Pictures of runs in a process of their own. Without OpenGL there are no pictures, and tests that look at them skip."""
import pathlib
import subprocess
import sys
import tempfile
import threading
import unittest

import turgor
from scenes import PAD_BODY, scene
from turgor.drawing import command

PRESSED = scene(0.2, "\n" + PAD_BODY + """[tool.finger]
body = "pad"
shape = { sphere = 0.006 }
press = { at_fraction = [0.5, 0.5, 1], depth = 0.003, start = 0, duration = 0.1 }
""")


def drawing_processes():
    """Numbers of the children of this process that draw."""
    found = set()
    for children in pathlib.Path("/proc/self/task").glob("*/children"):
        for child in children.read_text().split():
            if b"serve_drawings" in pathlib.Path("/proc", child, "cmdline").read_bytes():
                found.add(child)
    return found


def has_pictures(report):
    return any(picture["file"].endswith("-near.png") for picture in report["pictures"])


# Runs a scene with little memory beside that which the interpreter has, and prints the warnings.
SCRIPT = """
import json, resource, sys, turgor
size = int(open("/proc/self/statm").read().split()[0]) * resource.getpagesize()
limit = size + int(sys.argv[2]) * 1_000_000
resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
report = turgor.run(sys.argv[1], out="out", threads=1, force=True)
print(json.dumps(report["warnings"]))
"""


class Drawing(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = pathlib.Path(scratch.name)
        (self.folder / "s.toml").write_text(PRESSED)

    def run_scene(self):
        return turgor.run(self.folder / "s.toml", out=self.folder / "out", force=True)

    # A run draws in another process, which the next run uses again.
    def test_runs_draw_in_one_other_process(self):
        self.run_scene()
        first = drawing_processes()
        self.assertEqual(len(first), 1)
        self.run_scene()
        self.assertEqual(drawing_processes(), first)

    # The process ends with the thread that started it, and the next run has pictures too.
    def test_threads_that_end_cost_no_pictures(self):
        if not has_pictures(self.run_scene()):
            self.skipTest("no OpenGL")
        reports = []
        for _ in range(2):
            thread = threading.Thread(target=lambda: reports.append(self.run_scene()))
            thread.start()
            thread.join()
        reports.append(self.run_scene())
        self.assertEqual([has_pictures(report) for report in reports], [True] * 3)

    # With little memory OpenGL fails, and the run keeps its results: only pictures are missing, with a warning.
    def test_little_memory_costs_only_pictures(self):
        without_pictures = 0
        for megabytes in (60, 120, 240, 480):
            done = subprocess.run([sys.executable, "-c", SCRIPT, "s.toml", str(megabytes)], cwd=self.folder, capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, f"{megabytes} MB: {done.stderr}")
            warns = "no pictures of surfaces: cannot draw" in done.stdout
            self.assertEqual(warns, not (self.folder / "out/pad-near.png").exists(), f"{megabytes} MB: {done.stdout}")
            self.assertTrue((self.folder / "out/recording.h5").exists())
            without_pictures += warns
        self.assertGreater(without_pictures, 0, "expected a limit below the need of OpenGL")

    # A program with an interpreter inside is not started to draw.
    def test_only_interpreters_are_started(self):
        self.assertEqual(command("/usr/bin/python3.12", "e.so")[0], "/usr/bin/python3.12")
        for executable in ("/opt/viewer/viewer", "", None):
            self.assertEqual(command(executable, "e.so"), [])


if __name__ == "__main__":
    unittest.main()

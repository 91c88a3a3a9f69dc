"""Commands and snippets of docs/out-to-other-programs.md, as printed. test_document_blocks.py runs other pages."""
import contextlib
import importlib
import io
import os
import pathlib
import re
import shlex
import subprocess
import tempfile
import unittest
import unittest.mock

from scenes import PROGRAM
from test_ros2 import LOOPBACK

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGE = "docs/out-to-other-programs.md"
COARSE = "body.liver.resolution=0.02"


def blocks_of(page):
    """Blocks of Python code of a page."""
    return re.findall(r"```python\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), re.S)


class Documents(unittest.TestCase):
    # Every command of the page runs; a short duration, a free port and a coarse liver are added.
    def test_commands_of_live_programs_run(self):
        commands = re.findall(r"^    python -m (turgor\.(?:openigtlink|ros2)) (.*)$", (ROOT / PAGE).read_text(encoding="utf-8"), re.M)
        self.assertEqual([module for module, _ in commands], ["turgor.openigtlink", "turgor.ros2"])
        for name, arguments in commands:
            module = importlib.import_module(name)
            if getattr(module, "pyigtl", True) is None or getattr(module, "cyclonedds", True) is None:
                self.skipTest(f"a library of {name} is not installed")
            alone = ["--port", "0"] if name.endswith("openigtlink") else ["--domain", "199"]
            on_loopback = unittest.mock.patch.dict(os.environ, CYCLONEDDS_URI=LOOPBACK)
            with on_loopback, contextlib.chdir(ROOT), contextlib.redirect_stdout(io.StringIO()) as printed:
                ended = module.main([*shlex.split(arguments), "--seconds", "0.05", "--set", COARSE, *alone])
            self.assertEqual(ended, 0)
            self.assertIn("50 ticks", printed.getvalue())

    # The export command and the snippet of recordings run on a short recording of the scene.
    def test_export_of_recording_runs(self):
        text = (ROOT / PAGE).read_text(encoding="utf-8")
        command = re.search(r"^    python -m turgor.export (.*)$", text, re.M).group(1)
        block = next(block for block in blocks_of(PAGE) if "turgor.Recording" in block)
        with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder), contextlib.redirect_stdout(io.StringIO()) as printed:
            short = [word for one in (COARSE, "world.duration=0.05", "output.snapshots.every=0.05", "output.sections=false") for word in ("--set", one)]
            subprocess.run([PROGRAM, "run", ROOT / "scenes/palpation.toml", "-q", "--out", "out/palpation", *short], check=True)
            self.assertEqual(importlib.import_module("turgor.export").main(shlex.split(command)), 0)
            written = {file: pathlib.Path(file).read_bytes() for file in ("palpation.usda", "palpation.glb")}
            exec(block, {})  # pylint: disable=exec-used
            self.assertEqual({file: pathlib.Path(file).read_bytes() for file in written}, written)
        self.assertIn("palpation.glb: 2 snapshots", printed.getvalue())

    # The snippet of the live loop leads the finger of the scene.
    def test_live_loop_runs(self):
        block = next(block for block in blocks_of(PAGE) if "LiveWorld" in block)
        with contextlib.chdir(ROOT), contextlib.redirect_stdout(io.StringIO()) as printed:
            exec(block.replace("palpation.toml\"", f"palpation.toml\", set={dict([COARSE.split('=')])}".replace("'0.02'", "0.02")), {})
        self.assertIn(" 100 ", printed.getvalue())


if __name__ == "__main__":
    unittest.main()

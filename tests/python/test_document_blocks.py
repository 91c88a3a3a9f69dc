"""Python blocks of every page, run as printed from the first to the last. Shipped scenes are shortened and coarse.

What a page leaves to its reader (a CT, a mesh, a running world) is in GIVEN. A page without an entry runs by itself.
"""
import contextlib
import functools
import io
import pathlib
import re
import sys
import tempfile
import tomllib
import types
import unittest
from unittest import mock

import numpy as np

import turgor
from turgor import study_file
from scenes import FORCEPS, TORSO

ROOT = pathlib.Path(__file__).resolve().parents[2]
COARSE = {
    "palpation.toml": {"world.duration": 0.2, "body.liver.resolution": 0.02},
    "incision.toml": {"world.duration": 0.5, "body.torso.spacing": 0.013, "incision.midline.start": 0.02, "incision.midline.duration": 0.1},
    "abdomen.toml": {"organs.resolution": 0.03, "body.gallbladder.resolution": 0.02},
    "rigid.toml": {"body.liver.resolution": 0.03},
}
TESTED_ELSEWHERE = {"docs/out-to-other-programs.md": "test_documents.py, on a recording of a run"}


def pages():
    """Python blocks by page."""
    files = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    blocks = {str(file.relative_to(ROOT)): re.findall(r"```python\n(.*?)```", file.read_text(encoding="utf-8"), re.S) for file in files}
    return {page: found for page, found in blocks.items() if found}


def coarse(call):
    """A function that loads a scene, with the overrides of COARSE."""
    def load(scene=None, *args, **options):
        if isinstance(scene, str):
            options["set"] = COARSE[pathlib.Path(scene).name] | dict(options.get("set") or {})
            scene = ROOT / scene
        return call(scene, *args, **options)
    return load


def stepped(scene, frames):
    world = coarse(turgor.World)(f"scenes/{scene}")
    world.step(frames)
    return world


def given_to_python():
    """A CT as a file and as samples, and a surface."""
    import pyvista  # noqa: F401
    import SimpleITK
    torso, liver = turgor.World(text=TORSO)["torso"].volume(), turgor.World(text=FORCEPS)["liver"]
    SimpleITK.WriteImage(torso.to_sitk(), "ct.nrrd")
    return {"SimpleITK": SimpleITK, "hu": torso.samples, "points": liver.rest_points, "triangles": liver.triangles}


def given_to_recording():
    coarse(turgor.run)("scenes/incision.toml", out="out")
    pathlib.Path("out/recording.h5").rename("recording.h5")
    return {}


def given_to_slicer():
    import fake_slicer
    import Turgor
    from test_slicer import QUICK, line_on_belly, phantom, straight
    nodes = {"CT": fake_slicer.Volume("CT", *phantom()), "L": straight(line_on_belly())}
    util = types.SimpleNamespace(getNode=nodes.get)
    Turgor.CutOptions = functools.partial(Turgor.CutOptions, step=QUICK["step"], seconds=QUICK["seconds"])
    Turgor.shutil = types.SimpleNamespace(which=lambda name: sys.executable if name == "PythonSlicer" else None)
    return {"slicer": types.SimpleNamespace(util=util)}


GIVEN = {
    "docs/python.md": given_to_python,
    "docs/organs-in-contact.md": lambda: {"world": stepped("abdomen.toml", 5)},
    "docs/models/rigid.md": lambda: {"world": stepped("rigid.toml", 5)},
    "docs/recording.md": given_to_recording,
    "docs/slicer.md": given_to_slicer,
}


def run_page(page, blocks):
    """The names after the last block, and what was printed."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder), contextlib.ExitStack() as stack:
        printed = stack.enter_context(contextlib.redirect_stdout(io.StringIO()))
        names = GIVEN.get(page, dict)()
        for name in ("World", "run"):
            stack.enter_context(mock.patch.object(turgor, name, coarse(getattr(turgor, name))))
        if "pyvista" in sys.modules:  # opens a window
            stack.enter_context(mock.patch("pyvista.DataSet.plot"))
        for number, block in enumerate(blocks):
            exec(compile(block, f"{page}, block {number + 1}", "exec"), names)  # pylint: disable=exec-used
    return names, printed.getvalue()


class DocumentBlocks(unittest.TestCase):
    # Every block runs; a page whose libraries are not installed is skipped.
    def test_every_page_runs(self):
        self.assertGreaterEqual(len(pages()), 6)
        for page, blocks in pages().items():
            with self.subTest(page):
                if page in TESTED_ELSEWHERE:
                    continue
                try:
                    names, printed = run_page(page, blocks)
                except ModuleNotFoundError as missing:
                    self.skipTest(f"{page}: {missing.name} is not installed")
                CLAIMS.get(page, lambda *_: None)(self, names, printed)

    # Every study file of the documents is read, with the scene of the same page.
    def test_every_study_is_read(self):
        found = 0
        for page in (ROOT / "docs").rglob("*.md"):
            blocks = re.findall(r"```toml\n(.*?)```", page.read_text(encoding="utf-8"), re.S)
            scenes = [block for block in blocks if "[study]" not in block]
            for block in blocks:
                if block in scenes:
                    continue
                with self.subTest(page.name), tempfile.TemporaryDirectory() as name:
                    folder, tables = pathlib.Path(name), tomllib.loads(block)
                    (folder / "study.toml").write_text(block, encoding="utf-8")
                    (folder / "cohort.csv").write_text("name,body.torso.ct\nfirst,a.nii.gz\nsecond,b.nii.gz\n", encoding="utf-8")
                    shipped = ROOT / "scenes" / tables["study"]["scene"]
                    (folder / tables["study"]["scene"]).write_text(
                        shipped.read_text(encoding="utf-8") if shipped.exists() else scenes[0], encoding="utf-8")
                    study = study_file.Study(folder / "study.toml")
                    self.assertEqual(set(study.measure), set(tables["measure"]))
                    found += 1
        self.assertGreaterEqual(found, 2)

    def check_python(self, names, _):
        force = np.linalg.norm(names["wrench"][:, 0, :3], axis=1)
        self.assertLess(force[0], 0.01, "the hand begins outside")
        self.assertGreater(force.max(), 0.1, "it presses the liver")
        self.assertGreater(names["report"]["wounds"][0]["gape_max_mm"], 1)
        self.assertAlmostEqual(names["world"].measures("suture." + names["stitch"])["tension_max_N"][-1], 2.0, delta=0.1)
        self.assertEqual(names["envs"].num_envs, 64)

    def check_recording(self, names, printed):
        self.assertRegex(printed, r"largest displacement \[mm\]: [1-9]")
        self.assertEqual(names["points"].shape[1], 3)


CLAIMS = {"docs/python.md": DocumentBlocks.check_python, "docs/recording.md": DocumentBlocks.check_recording}


if __name__ == "__main__":
    unittest.main()

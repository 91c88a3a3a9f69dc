"""The module of 3D Slicer on a fake of Slicer: positions are compared in RAS, for cuts by the module and by the program."""
import functools
import pathlib
import shutil
import sys
import tempfile
import time
import unittest
from unittest import mock

import numpy as np

import turgor
from scenes import PROGRAM, TORSO

try:
    import fake_slicer as slicer
except ImportError:
    slicer = None
else:
    import Turgor
    from TurgorLib import cut, nrrd_file

LPS = np.diag([-1.0, -1.0, 1.0, 1.0])  # to and from RAS
QUICK = {"depth": 20, "step": 13, "seconds": 0.3}
GAPE, GAPE_MEAN, AREA = 0, 1, 2  # rows of the measures


@functools.lru_cache
def phantom():
    """A torso: samples (k, j, i) and the matrix from (i, j, k, 1) to RAS [mm]."""
    volume = turgor.World(text=TORSO)["torso"].volume()
    return volume.samples, LPS @ np.diag([1e3, 1e3, 1e3, 1]) @ volume.affine


@functools.lru_cache
def line_on_belly():
    """(2, 3), RAS [mm]: an oblique line beside the middle, on the first tissue from the front."""
    samples, to_ras = phantom()
    points = []
    for i, k in ((36, 26), (40, 14)):
        j = np.argmax(samples[k, :, i] > -300)
        points.append((to_ras @ [i, j, k, 1])[:3])
    return np.array(points)


def turn(axis, degrees, shift):
    """(4, 4), a rotation about an axis, then a shift [mm]."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    angle = np.radians(degrees)
    matrix = np.eye(4)
    matrix[:3, :3] += np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    matrix[:3, 3] = shift
    return matrix


OBLIQUE = turn([1, 2, 3], 35, [120, -300, 550])


def transformed(points, matrix):
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def oblique_left_handed(backwards=2):
    """The same patient, rotated and stored along other axes, one of them flipped: samples, matrix, line."""
    samples, to_ras = phantom()
    stored = np.flip(samples.transpose(2, 0, 1), 2 - backwards)  # i from front to back, j along the body, k from side to side
    columns = (OBLIQUE @ to_ras)[:, [1, 2, 0, 3]]
    columns[:3, 3] += columns[:3, backwards] * (stored.shape[2 - backwards] - 1)
    columns[:3, backwards] *= -1
    return stored, columns, transformed(line_on_belly(), OBLIQUE)


def distance_to(line, points):
    """(n,) distances [mm] of points from the straight line between two."""
    along = line[1] - line[0]
    t = np.clip((points - line[0]) @ along / (along @ along), 0, 1)
    return np.linalg.norm(points - line[0] - t[:, None] * along, axis=1)


def corners(model):
    from vtk.util.numpy_support import vtk_to_numpy

    return vtk_to_numpy(model.surface.GetPoints().GetData())


def positions_of(where, to_ras):
    """(n, 3), RAS [mm], of voxels (k, j, i) that are True."""
    k, j, i = np.nonzero(where)
    return transformed(np.column_stack([i, j, k]), to_ras)


def straight(points):
    return slicer.Markups("vtkMRMLMarkupsLineNode", points)


@unittest.skipIf(slicer is None, "VTK is not installed")
class Slicer(unittest.TestCase):
    def setUp(self):
        slicer.mrmlScene.Clear()
        self.logic = Turgor.TurgorLogic()
        python = mock.patch.object(Turgor.shutil, "which", lambda name: sys.executable if name == "PythonSlicer" else None)
        python.start()
        self.addCleanup(python.stop)

    def cut(self, samples, to_ras, line, program="", **options):
        volume = slicer.Volume("CT", samples, to_ras)
        return self.logic.cut(volume, straight(line), cut.CutOptions(**{**QUICK, **options}), program=program)

    def refused(self, sentence):
        return self.assertRaisesRegex(cut.CutError, sentence)

    def check_opened(self, nodes, samples, to_ras, line):
        wall = corners(nodes["wound"])
        self.assertGreater(len(wall), 20)
        self.assertLess(distance_to(line, wall).max(), 45)  # depth 20, half the gape, one spacing of the lattice
        self.assertLess(distance_to(line, wall.mean(axis=0)[None])[0], 20)
        along = (wall - line[0]) @ (line[1] - line[0]) / np.sum((line[1] - line[0]) ** 2)
        self.assertTrue(along.min() < 0.15 and along.max() > 0.85, (along.min(), along.max()))  # from end to end
        gone = (samples > -300) & (nodes["volume"].samples < -500)
        self.assertGreater(gone.sum(), 3)
        self.assertLess(np.median(distance_to(line, positions_of(gone, to_ras))), 15)
        middle = positions_of(gone, to_ras).mean(axis=0)
        self.assertLess(np.linalg.norm(middle - line.mean(axis=0)), 25)

    # The wound opens along the line, in volumes with oblique, left-handed axes.
    def test_wound_follows_line_in_left_handed_volume(self):
        for backwards in range(3):
            self.check_unmoved(*oblique_left_handed(backwards))

    def check_unmoved(self, samples, to_ras, line):
        self.assertLess(np.linalg.det(to_ras[:3, :3]), 0)
        nodes = self.cut(samples, to_ras, line)
        self.check_opened(nodes, samples, to_ras, line)
        self.assertEqual(nodes["volume"].samples.shape, samples.shape)
        np.testing.assert_array_equal(nodes["volume"].ijk_to_ras, to_ras)
        far = distance_to(line, positions_of(np.ones(samples.shape, bool), to_ras)).reshape(samples.shape) > 120
        changed = np.abs(nodes["volume"].samples[far].astype(int) - samples[far]) > 40
        self.assertLess(changed.mean(), 1e-3)  # except single voxels at the border of the body

    # The wound of a rotated patient is the rotated wound.
    def test_wound_is_invariant_under_rotation(self):
        samples, to_ras = phantom()
        plain = self.cut(samples, to_ras, line_on_belly())
        self.check_opened(plain, samples, to_ras, line_on_belly())
        stored, turned_to_ras, line = oblique_left_handed()
        turned = self.logic.cut(slicer.Volume("CT", stored, turned_to_ras), straight(line), cut.CutOptions(**QUICK),
                                straight(OBLIQUE[:3, 3] + np.array([[0, 0, 0], OBLIQUE[:3, 0]])))
        np.testing.assert_allclose(turned["measures"].columns["value"], plain["measures"].columns["value"], rtol=0.02)
        np.testing.assert_allclose(transformed(corners(plain["wound"]), OBLIQUE), corners(turned["wound"]), atol=0.5)

    # The program and the Python module give the same results.
    def test_program_matches_module(self):
        samples, to_ras, line = oblique_left_handed()
        by_module, by_program = (self.cut(samples, to_ras, line, program) for program in ("", PROGRAM))
        np.testing.assert_array_equal(by_module["volume"].samples, by_program["volume"].samples)
        for node in ("skin", "wound"):
            np.testing.assert_array_equal(corners(by_module[node]), corners(by_program[node]))
        self.assertEqual(by_module["measures"].columns, by_program["measures"].columns)
        self.assertEqual(by_module["profile"].columns, by_program["profile"].columns)

    # Measures have units, and the gape grows with the skin tension.
    def test_measures_grow_with_tension(self):
        samples, to_ras = phantom()
        slack, tense = (self.cut(samples, to_ras, line_on_belly(), tension=(n, n))["measures"].columns for n in (20, 60))
        self.assertEqual(tense["measure"][:3], ["gape, largest", "gape, mean", "opening area"])
        self.assertEqual(tense["unit"][:3], ["mm", "mm", "mm²"])
        self.assertGreater(tense["value"][GAPE], 1.5 * slack["value"][GAPE])
        self.assertTrue(1 < tense["value"][GAPE] < 60)
        self.assertEqual(tense["value"][tense["measure"].index("depth")], QUICK["depth"])

    # Langer's lines are given in the RAS of the scene, also for a transformed volume.
    def test_langer_lines_respect_transform(self):
        samples, to_ras = phantom()
        world = turn([3, -1, 2], 50, [-40, 90, 10])
        line, along = line_on_belly(), line_on_belly()[1] - line_on_belly()[0]
        across = np.cross(along, [0, 1, 0])
        gapes = []
        for langer in (along, across):
            volume = slicer.Volume("CT", samples, to_ras)
            volume.SetAndObserveTransformNodeID(slicer.mrmlScene.add(slicer.Transform(world)))
            drawn = straight(transformed(np.array([[0, 0, 0], langer]), world))
            nodes = self.logic.cut(volume, straight(transformed(line, world)), cut.CutOptions(tension=(60, 20), **QUICK), drawn)
            self.check_opened(nodes, samples, to_ras, line)  # its nodes have the same transform
            self.assertEqual({nodes[name].GetTransformNodeID() for name in ("volume", "skin", "wound")}, {volume.GetTransformNodeID()})
            gapes.append(nodes["measures"].columns["value"][GAPE])
        self.assertGreater(gapes[1], 1.3 * gapes[0])  # a cut across Langer's lines gapes more

    # The cut follows a curved markup.
    def test_cut_follows_curve(self):
        samples, to_ras = phantom()
        start, end = line_on_belly()
        t = np.linspace(0, 1, 80)[:, None]
        bow = start + t * (end - start) + 30 * np.sin(np.pi * t) * np.array([1.0, 0, 0])
        markup = slicer.Markups("vtkMRMLMarkupsCurveNode", bow[[0, 40, 79]], curve=bow)
        nodes = self.logic.cut(slicer.Volume("CT", samples, to_ras), markup, cut.CutOptions(**QUICK))
        nearest = np.min(np.linalg.norm(corners(nodes["wound"])[:, None] - bow[None], axis=2), axis=1)
        self.assertLess(nearest.max(), 45)
        middle = np.abs(corners(nodes["wound"])[:, 2] - bow[40, 2]) < 10
        self.assertGreater(corners(nodes["wound"])[middle, 0].mean() - (start + end)[0] / 2, 15)

    # A closed curve is cut over its whole length.
    def test_closed_curve_is_cut_all_around(self):
        samples, to_ras = phantom()
        middle, angle = line_on_belly().mean(axis=0), np.linspace(0, 2 * np.pi, 60, endpoint=False)
        ring = middle + 40 * np.column_stack([np.cos(angle), 0 * angle, np.sin(angle)])
        markup = slicer.Markups("vtkMRMLMarkupsClosedCurveNode", ring[::15], curve=ring)
        nodes = self.logic.cut(slicer.Volume("CT", samples, to_ras), markup, cut.CutOptions(**QUICK))
        radius = corners(nodes["wound"]) - middle
        around = np.degrees(np.arctan2(radius[:, 2], radius[:, 0]))
        self.assertEqual(len(set(np.floor(around / 45))), 8)
        self.assertGreater(np.linalg.norm(radius[:, [0, 2]], axis=1).min(), 15)

    # A line far from the body is rejected; the error states the extent of the body.
    def test_line_far_from_body_is_rejected(self):
        samples, to_ras, line = oblique_left_handed()
        for program in ("", PROGRAM):
            with self.refused("^no skin within.*the body is between.*R and A of Slicer with the opposite"):
                self.cut(samples, to_ras, line + 900, program)
        self.assertEqual(slicer.mrmlScene.nodes, [])

    # Missing or unsuitable input gives an error message.
    def test_unsuitable_input_is_explained(self):
        samples, to_ras = phantom()
        volume, line = slicer.Volume("CT", samples, to_ras), straight(line_on_belly())
        bent = slicer.Volume("CT", samples, to_ras)
        bent.SetAndObserveTransformNodeID(slicer.mrmlScene.add(slicer.Transform(np.eye(4), linear=False)))
        stretched = slicer.Volume("CT", samples, to_ras)
        stretched.SetAndObserveTransformNodeID(slicer.mrmlScene.add(slicer.Transform(np.diag([2.0, 1, 1, 1]))))
        for given, drawn, sentence in ((None, line, "Select a volume"), (slicer.Volume("empty"), line, "Select a volume"),
                                       (slicer.Volume("color", np.zeros((4, 4, 4, 3))), line, "one number per voxel, found 3"),
                                       (volume, None, "Draw a line"), (volume, straight([[0, 0, 0]]), "has 1 point: expected at least two"),
                                       (volume, straight([[0, 0, 0], [0, 0, 0.5]]), "shorter than a millimeter"),
                                       (volume, slicer.Markups(line.kind, line.points, previewed=1), "still being drawn"),
                                       (bent, line, "nonlinear transform"), (stretched, line, "stretches")):
            with self.refused(sentence):
                self.logic.begin(given, drawn)
        with self.refused("0 voxels|no tissue|air|body"):
            self.cut(np.full((20, 20, 20), -1000), np.diag([5.0, 5, 5, 1]), np.array([[10.0, 10, 10], [50, 10, 10]]))
        with self.refused("axes|square|shear"):
            sheared = to_ras.copy()
            sheared[0, 2] += 3
            self.cut(samples, sheared, line_on_belly())
        with self.refused("tension"):
            self.cut(samples, to_ras, line_on_belly(), tension=(400, 400))

    # Without Turgor the error states what to install or which path to set.
    def test_missing_turgor_is_explained(self):
        samples, to_ras = phantom()
        with mock.patch.object(cut.importlib.util, "find_spec", lambda name: None), self.refused("pip_install.*path of the program turgor"):
            self.cut(samples, to_ras, line_on_belly())
        with mock.patch.object(Turgor.shutil, "which", lambda name: None), self.refused("PythonSlicer.*was not found"):
            self.cut(samples, to_ras, line_on_belly())
        with self.refused("/nowhere/turgor: expected the program turgor"):
            self.cut(samples, to_ras, line_on_belly(), "/nowhere/turgor")
        with self.refused("no message|started"):
            self.cut(samples, to_ras, line_on_belly(), "/bin/false")

    # NaN becomes air; other values are rounded and clamped to 16 bits.
    def test_hounsfield_rounds_and_clamps(self):
        given = np.array([[[np.nan, 39.6, -99999.0]]])
        np.testing.assert_array_equal(cut.hounsfield(given), [[[-1000, 40, -32768]]])

    # An NRRD file keeps samples and affine matrix exactly.
    def test_nrrd_file_round_trips(self):
        samples, to_ras, _ = oblique_left_handed()
        with tempfile.TemporaryDirectory() as folder:
            nrrd_file.write(f"{folder}/v.nrrd", samples, LPS @ to_ras)
            read, affine = nrrd_file.read(f"{folder}/v.nrrd")
        np.testing.assert_array_equal(read, samples)
        np.testing.assert_array_equal(affine, LPS @ to_ras)


@unittest.skipIf(slicer is None, "VTK is not installed")
class Panel(unittest.TestCase):
    def setUp(self):
        slicer.mrmlScene.Clear()
        slicer.Settings.kept.clear()
        self.folders = mock.patch.object(tempfile, "tempdir", tempfile.mkdtemp())
        self.folders.start()
        self.addCleanup(shutil.rmtree, tempfile.tempdir)
        self.addCleanup(self.folders.stop)
        self.panel = Turgor.TurgorWidget()
        self.panel.setup()
        self.panel.program.currentPath = PROGRAM
        samples, to_ras = phantom()
        self.panel.volume.chosen = slicer.Volume("CT", samples, to_ras)
        self.panel.line.chosen = straight(line_on_belly())
        self.panel.depth.value, self.panel.step.value, self.panel.seconds.value = 20, 13, 0.3

    def left_behind(self):
        return list(pathlib.Path(tempfile.tempdir).iterdir())

    # The button starts the cut, shows its progress and adds the results to the scene.
    def test_button_cuts_and_shows_progress(self):
        self.panel.seconds.value = 1.5  # long enough to observe the progress
        self.panel.cutButton.click()
        self.assertFalse(self.panel.cutButton.enabled)
        progress = []
        while self.panel.timer.running:
            time.sleep(0.01)
            self.panel.timer.tick()
            progress.append(self.panel.bar.value)
        self.assertIn("The wound is open: see CT wound measures", self.panel.message.text)
        self.assertTrue(self.panel.cutButton.enabled)
        self.assertTrue(any(0 < value < 100 for value in progress), progress)
        self.assertEqual([node.name for node in slicer.mrmlScene.nodes],
                         ["CT cut", "CT skin", "CT wound", "CT wound measures", "CT gape along the cut"])
        self.assertIs(slicer.shown["background"], slicer.mrmlScene.nodes[0])
        self.assertEqual(slicer.Settings.kept["Turgor/program"], PROGRAM)
        self.assertEqual(self.left_behind(), [])

    # Cancelling, closing the scene or the panel ends the process and leaves no files.
    def test_cancel_ends_and_leaves_nothing(self):
        self.panel.seconds.value = 60
        for stop in (self.panel.cancelButton.click, slicer.mrmlScene.observers[slicer.Scene.StartCloseEvent], self.panel.cleanup):
            self.panel.cutButton.click()
            process = self.panel.running.cut.process
            time.sleep(0.3)
            self.assertIsNone(process.poll())
            stop()
            self.assertIsNotNone(process.poll())
            self.assertIn("Cancelled", self.panel.message.text)
            self.assertFalse(self.panel.timer.running)
            self.assertEqual(slicer.mrmlScene.nodes, [])
            self.assertEqual(self.left_behind(), [])

    # Errors appear in the panel.
    def test_errors_appear_in_panel(self):
        self.panel.line.chosen = None
        self.panel.cutButton.click()
        self.assertIn("Draw a line", self.panel.message.text)
        self.assertTrue(self.panel.cutButton.enabled)
        self.panel.line.chosen = straight(line_on_belly() + 900)
        self.panel.cutButton.click()
        while self.panel.timer.running:
            time.sleep(0.01)
            self.panel.timer.tick()
        self.assertIn("no skin within", self.panel.message.text)
        self.assertEqual(self.left_behind(), [])


@unittest.skipIf(slicer is None, "VTK is not installed")
class Worker(unittest.TestCase):
    # A worker started by a launcher stops when its scene file is removed.
    def test_worker_stops_when_scene_is_removed(self):
        samples, to_ras = phantom()
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            nrrd_file.write(folder / "volume.nrrd", samples, LPS @ to_ras)
            scene = folder / "scene.toml"
            scene.write_text(cut.scene_text(line_on_belly(), cut.CutOptions(**{**QUICK, "seconds": 600})))
            worker = cut.subprocess.Popen([sys.executable, slicer.MODULE / "TurgorLib/worker.py", folder], stdout=cut.subprocess.PIPE, text=True)
            while not worker.stdout.readline().startswith("simulating"):
                self.assertIsNone(worker.poll())
            scene.unlink()
            worker.communicate(timeout=20)
            self.assertEqual(worker.returncode, 130)
            self.assertFalse((folder / "out").exists())


if __name__ == "__main__":
    unittest.main()

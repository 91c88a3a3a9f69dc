"""The module of 3D Slicer over a fake of the few calls it makes: places are compared in RAS, through both of its ways to cut."""
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
    """(2, 3), RAS [mm]: beside the middle and aslant, on the first tissue from the front."""
    samples, to_ras = phantom()
    places = []
    for i, k in ((36, 26), (40, 14)):
        j = np.argmax(samples[k, :, i] > -300)
        places.append((to_ras @ [i, j, k, 1])[:3])
    return np.array(places)


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


def laid(points, matrix):
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def oblique_left_handed(backwards=2):
    """The same patient turned in space and stored along other axes, one of them backwards: samples, matrix, line."""
    samples, to_ras = phantom()
    stored = np.flip(samples.transpose(2, 0, 1), 2 - backwards)  # i from front to back, j along the body, k from side to side
    columns = (OBLIQUE @ to_ras)[:, [1, 2, 0, 3]]
    columns[:3, 3] += columns[:3, backwards] * (stored.shape[2 - backwards] - 1)
    columns[:3, backwards] *= -1
    return stored, columns, laid(line_on_belly(), OBLIQUE)


def way_to(line, points):
    """(n,) distances [mm] of points from the straight line between two."""
    along = line[1] - line[0]
    part = np.clip((points - line[0]) @ along / (along @ along), 0, 1)
    return np.linalg.norm(points - line[0] - part[:, None] * along, axis=1)


def corners(model):
    from vtk.util.numpy_support import vtk_to_numpy

    return vtk_to_numpy(model.surface.GetPoints().GetData())


def places_of(where, to_ras):
    """(n, 3), RAS [mm], of voxels (k, j, i) that are True."""
    k, j, i = np.nonzero(where)
    return laid(np.column_stack([i, j, k]), to_ras)


def straight(points):
    return slicer.Markups("vtkMRMLMarkupsLineNode", points)


@unittest.skipIf(slicer is None, "VTK cannot be had here")
class Slicer(unittest.TestCase):
    def setUp(self):
        slicer.mrmlScene.Clear()
        self.logic = Turgor.TurgorLogic()
        python = mock.patch.object(Turgor.shutil, "which", lambda name: sys.executable if name == "PythonSlicer" else None)
        python.start()
        self.addCleanup(python.stop)

    def cut(self, samples, to_ras, line, program="", **wishes):
        volume = slicer.Volume("CT", samples, to_ras)
        return self.logic.cut(volume, straight(line), cut.Wishes(**{**QUICK, **wishes}), program=program)

    def refused(self, sentence):
        return self.assertRaisesRegex(cut.CutError, sentence)

    def check_opened(self, nodes, samples, to_ras, line):
        wall = corners(nodes["wound"])
        self.assertGreater(len(wall), 20)
        self.assertLess(way_to(line, wall).max(), 45)  # depth 20, half a gape, a step of the lattice
        self.assertLess(way_to(line, wall.mean(axis=0)[None])[0], 20)
        along = (wall - line[0]) @ (line[1] - line[0]) / np.sum((line[1] - line[0]) ** 2)
        self.assertTrue(along.min() < 0.15 and along.max() > 0.85, (along.min(), along.max()))  # from end to end
        gone = (samples > -300) & (nodes["volume"].samples < -500)
        self.assertGreater(gone.sum(), 3)
        self.assertLess(np.median(way_to(line, places_of(gone, to_ras))), 15)
        middle = places_of(gone, to_ras).mean(axis=0)
        self.assertLess(np.linalg.norm(middle - line.mean(axis=0)), 25)

    def test_a_wound_opens_where_the_line_lies_in_an_oblique_left_handed_volume(self):
        for backwards in range(3):
            self.check_in_place(*oblique_left_handed(backwards))

    def check_in_place(self, samples, to_ras, line):
        self.assertLess(np.linalg.det(to_ras[:3, :3]), 0)
        nodes = self.cut(samples, to_ras, line)
        self.check_opened(nodes, samples, to_ras, line)
        self.assertEqual(nodes["volume"].samples.shape, samples.shape)
        np.testing.assert_array_equal(nodes["volume"].ijk_to_ras, to_ras)
        far = way_to(line, places_of(np.ones(samples.shape, bool), to_ras)).reshape(samples.shape) > 120
        changed = np.abs(nodes["volume"].samples[far].astype(int) - samples[far]) > 40
        self.assertLess(changed.mean(), 1e-3)  # but for single voxels at the border of the body

    def test_it_is_the_wound_of_the_same_patient_lying_straight(self):
        samples, to_ras = phantom()
        plain = self.cut(samples, to_ras, line_on_belly())
        self.check_opened(plain, samples, to_ras, line_on_belly())
        stored, turned_to_ras, line = oblique_left_handed()
        turned = self.logic.cut(slicer.Volume("CT", stored, turned_to_ras), straight(line), cut.Wishes(**QUICK),
                                straight(OBLIQUE[:3, 3] + np.array([[0, 0, 0], OBLIQUE[:3, 0]])))
        np.testing.assert_allclose(turned["measures"].columns["value"], plain["measures"].columns["value"], rtol=0.02)
        np.testing.assert_allclose(laid(corners(plain["wound"]), OBLIQUE), corners(turned["wound"]), atol=0.5)

    def test_the_program_gives_what_the_module_gives(self):
        samples, to_ras, line = oblique_left_handed()
        by_module, by_program = (self.cut(samples, to_ras, line, program) for program in ("", PROGRAM))
        np.testing.assert_array_equal(by_module["volume"].samples, by_program["volume"].samples)
        for node in ("skin", "wound"):
            np.testing.assert_array_equal(corners(by_module[node]), corners(by_program[node]))
        self.assertEqual(by_module["measures"].columns, by_program["measures"].columns)
        self.assertEqual(by_module["profile"].columns, by_program["profile"].columns)

    def test_measures_have_their_units_and_grow_with_the_tension(self):
        samples, to_ras = phantom()
        slack, tense = (self.cut(samples, to_ras, line_on_belly(), tension=(n, n))["measures"].columns for n in (20, 60))
        self.assertEqual(tense["measure"][:3], ["gape, largest", "gape, mean", "opening area"])
        self.assertEqual(tense["unit"][:3], ["mm", "mm", "mm²"])
        self.assertGreater(tense["value"][GAPE], 1.5 * slack["value"][GAPE])
        self.assertTrue(1 < tense["value"][GAPE] < 60)
        self.assertEqual(tense["value"][tense["measure"].index("depth")], QUICK["depth"])

    def test_langers_lines_are_drawn_in_the_scenes_ras_also_of_a_volume_under_a_transform(self):
        samples, to_ras = phantom()
        world = turn([3, -1, 2], 50, [-40, 90, 10])
        line, along = line_on_belly(), line_on_belly()[1] - line_on_belly()[0]
        across = np.cross(along, [0, 1, 0])
        gapes = []
        for langer in (along, across):
            volume = slicer.Volume("CT", samples, to_ras)
            volume.SetAndObserveTransformNodeID(slicer.mrmlScene.add(slicer.Transform(world)))
            drawn = straight(laid(np.array([[0, 0, 0], langer]), world))
            nodes = self.logic.cut(volume, straight(laid(line, world)), cut.Wishes(tension=(60, 20), **QUICK), drawn)
            self.check_opened(nodes, samples, to_ras, line)  # its own nodes lie under the same transform
            self.assertEqual({nodes[name].GetTransformNodeID() for name in ("volume", "skin", "wound")}, {volume.GetTransformNodeID()})
            gapes.append(nodes["measures"].columns["value"][GAPE])
        self.assertGreater(gapes[1], 1.3 * gapes[0])  # a cut across Langer's lines gapes more

    def test_a_curve_is_followed_where_it_bends(self):
        samples, to_ras = phantom()
        start, end = line_on_belly()
        part = np.linspace(0, 1, 80)[:, None]
        bow = start + part * (end - start) + 30 * np.sin(np.pi * part) * np.array([1.0, 0, 0])
        markup = slicer.Markups("vtkMRMLMarkupsCurveNode", bow[[0, 40, 79]], curve=bow)
        nodes = self.logic.cut(slicer.Volume("CT", samples, to_ras), markup, cut.Wishes(**QUICK))
        nearest = np.min(np.linalg.norm(corners(nodes["wound"])[:, None] - bow[None], axis=2), axis=1)
        self.assertLess(nearest.max(), 45)
        middle = np.abs(corners(nodes["wound"])[:, 2] - bow[40, 2]) < 10
        self.assertGreater(corners(nodes["wound"])[middle, 0].mean() - (start + end)[0] / 2, 15)

    def test_a_closed_curve_is_cut_all_around(self):
        samples, to_ras = phantom()
        middle, angle = line_on_belly().mean(axis=0), np.linspace(0, 2 * np.pi, 60, endpoint=False)
        ring = middle + 40 * np.column_stack([np.cos(angle), 0 * angle, np.sin(angle)])
        markup = slicer.Markups("vtkMRMLMarkupsClosedCurveNode", ring[::15], curve=ring)
        nodes = self.logic.cut(slicer.Volume("CT", samples, to_ras), markup, cut.Wishes(**QUICK))
        way = corners(nodes["wound"]) - middle
        around = np.degrees(np.arctan2(way[:, 2], way[:, 0]))
        self.assertEqual(len(set(np.floor(around / 45))), 8)
        self.assertGreater(np.linalg.norm(way[:, [0, 2]], axis=1).min(), 15)

    def test_a_line_far_from_the_body_is_refused_with_where_the_body_is(self):
        samples, to_ras, line = oblique_left_handed()
        for program in ("", PROGRAM):
            with self.refused("^no skin within.*the body lies between.*R and A with the other sign"):
                self.cut(samples, to_ras, line + 900, program)
        self.assertEqual(slicer.mrmlScene.nodes, [])

    def test_what_is_not_there_or_not_fit_is_a_sentence(self):
        samples, to_ras = phantom()
        volume, line = slicer.Volume("CT", samples, to_ras), straight(line_on_belly())
        bent = slicer.Volume("CT", samples, to_ras)
        bent.SetAndObserveTransformNodeID(slicer.mrmlScene.add(slicer.Transform(np.eye(4), linear=False)))
        stretched = slicer.Volume("CT", samples, to_ras)
        stretched.SetAndObserveTransformNodeID(slicer.mrmlScene.add(slicer.Transform(np.diag([2.0, 1, 1, 1]))))
        for given, drawn, sentence in ((None, line, "Pick a volume"), (slicer.Volume("empty"), line, "Pick a volume"),
                                       (slicer.Volume("color", np.zeros((4, 4, 4, 3))), line, "one number a voxel, found 3"),
                                       (volume, None, "Draw a line"), (volume, straight([[0, 0, 0]]), "has 1 point: expected at least two"),
                                       (volume, straight([[0, 0, 0], [0, 0, 0.5]]), "shorter than a millimetre"),
                                       (volume, slicer.Markups(line.kind, line.points, previewed=1), "still being drawn"),
                                       (bent, line, "bends"), (stretched, line, "stretches")):
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

    def test_without_turgor_it_says_what_to_install_or_where_to_point(self):
        samples, to_ras = phantom()
        with mock.patch.object(cut.importlib.util, "find_spec", lambda name: None), self.refused("pip_install.*where the program turgor is"):
            self.cut(samples, to_ras, line_on_belly())
        with mock.patch.object(Turgor.shutil, "which", lambda name: None), self.refused("PythonSlicer.*was not found"):
            self.cut(samples, to_ras, line_on_belly())
        with self.refused("/nowhere/turgor: expected the program turgor"):
            self.cut(samples, to_ras, line_on_belly(), "/nowhere/turgor")
        with self.refused("it said nothing|started"):
            self.cut(samples, to_ras, line_on_belly(), "/bin/false")

    def test_numbers_that_are_none_are_air_and_others_are_rounded_into_range(self):
        given = np.array([[[np.nan, 39.6, -99999.0]]])
        np.testing.assert_array_equal(cut.hounsfield(given), [[[-1000, 40, -32768]]])

    def test_a_volumes_file_keeps_its_place_to_the_last_bit(self):
        samples, to_ras, _ = oblique_left_handed()
        with tempfile.TemporaryDirectory() as folder:
            nrrd_file.write(f"{folder}/v.nrrd", samples, LPS @ to_ras)
            read, affine = nrrd_file.read(f"{folder}/v.nrrd")
        np.testing.assert_array_equal(read, samples)
        np.testing.assert_array_equal(affine, LPS @ to_ras)


@unittest.skipIf(slicer is None, "VTK cannot be had here")
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

    def test_the_button_cuts_and_tells_how_far_it_is(self):
        self.panel.seconds.value = 1.5  # long enough to be looked at meanwhile
        self.panel.cutButton.click()
        self.assertFalse(self.panel.cutButton.enabled)
        told = []
        while self.panel.timer.running:
            time.sleep(0.01)
            self.panel.timer.tick()
            told.append(self.panel.bar.value)
        self.assertIn("The wound is open: see CT wound measures", self.panel.said.text)
        self.assertTrue(self.panel.cutButton.enabled)
        self.assertTrue(any(0 < value < 100 for value in told), told)
        self.assertEqual([node.name for node in slicer.mrmlScene.nodes],
                         ["CT cut", "CT skin", "CT wound", "CT wound measures", "CT gape along the cut"])
        self.assertIs(slicer.shown["background"], slicer.mrmlScene.nodes[0])
        self.assertEqual(slicer.Settings.kept["Turgor/program"], PROGRAM)
        self.assertEqual(self.left_behind(), [])

    def test_cancelled_it_ends_at_once_and_leaves_nothing(self):
        self.panel.seconds.value = 60
        for stop in (self.panel.cancelButton.click, slicer.mrmlScene.observers[slicer.Scene.StartCloseEvent], self.panel.cleanup):
            self.panel.cutButton.click()
            process = self.panel.under_way.cut.process
            time.sleep(0.3)
            self.assertIsNone(process.poll())
            stop()
            self.assertIsNotNone(process.poll())
            self.assertIn("Cancelled", self.panel.said.text)
            self.assertFalse(self.panel.timer.running)
            self.assertEqual(slicer.mrmlScene.nodes, [])
            self.assertEqual(self.left_behind(), [])

    def test_what_is_refused_stands_in_the_panel(self):
        self.panel.line.chosen = None
        self.panel.cutButton.click()
        self.assertIn("Draw a line", self.panel.said.text)
        self.assertTrue(self.panel.cutButton.enabled)
        self.panel.line.chosen = straight(line_on_belly() + 900)
        self.panel.cutButton.click()
        while self.panel.timer.running:
            time.sleep(0.01)
            self.panel.timer.tick()
        self.assertIn("no skin within", self.panel.said.text)
        self.assertEqual(self.left_behind(), [])


@unittest.skipIf(slicer is None, "VTK cannot be had here")
class Behind(unittest.TestCase):
    def test_a_worker_behind_a_launcher_stops_when_its_scene_is_gone(self):
        samples, to_ras = phantom()
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            nrrd_file.write(folder / "volume.nrrd", samples, LPS @ to_ras)
            scene = folder / "scene.toml"
            scene.write_text(cut.scene_text(line_on_belly(), cut.Wishes(**{**QUICK, "seconds": 600})))
            worker = cut.subprocess.Popen([sys.executable, slicer.MODULE / "TurgorLib/worker.py", folder], stdout=cut.subprocess.PIPE, text=True)
            while not worker.stdout.readline().startswith("simulating"):
                self.assertIsNone(worker.poll())
            scene.unlink()
            worker.communicate(timeout=20)
            self.assertEqual(worker.returncode, 130)
            self.assertFalse((folder / "out").exists())


if __name__ == "__main__":
    unittest.main()

"""Worlds from volumes, meshes and numbers, and conversions from and to other packages."""
import pathlib
import tempfile
import tomllib
import types
import unittest

import numpy as np

import turgor
from scenes import CLOTH, FORCEPS, PAD
from turgor.scenes import GivenScene
from turgor.world import _file_and_text


def _package(name, test):
    try:
        return __import__(name)
    except ImportError:
        test.skipTest(f"{name} is not installed")


class Values(unittest.TestCase):
    def phantom(self):
        """A box of muscle in air with a bone inside: (k, j, i)."""
        hu = np.full((24, 28, 32), -1000, dtype=np.int16)
        hu[4:20, 4:24, 4:28] = 40
        hu[8:16, 12:16, 6:26] = 700
        return hu

    def scene(self, ct):
        return {"world": {"duration": 0.1, "frame_rate": 50, "gravity": [0, 0, -9.81]},
                "body": {"block": {"model": "lattice", "ct": ct, "block": 2, "fixed": ["bone"]}}}

    # A volume in memory gives the same state as its file.
    def test_volume_in_memory_matches_file(self):
        axes = np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]])
        volume = turgor.Volume(self.phantom(), (2e-3, 2e-3, 3e-3), (0.01, -0.02, 0.03), axes)
        memory = turgor.World(self.scene(volume))
        memory.step(4)
        as_file = turgor.World(self.scene("no-such-file.nii"), volumes={"block": volume})
        as_file.step(4)
        self.assertEqual(memory.state_hash, as_file.state_hash)
        back = memory["block"].volume()
        np.testing.assert_array_equal(back.samples, volume.samples)
        np.testing.assert_allclose(back.affine, volume.affine, atol=1e-12)
        moved = memory["block"].deformed_volume()
        self.assertEqual(moved.samples.shape, volume.samples.shape)
        self.assertFalse(np.array_equal(moved.samples, volume.samples))
        with tempfile.TemporaryDirectory() as folder:
            nibabel = _package("nibabel", self)
            file = pathlib.Path(folder) / "block.nii"
            nibabel.save(volume.to_nibabel(), file)
            read = turgor.World(self.scene(file))
            read.step(4)
        self.assertLess(np.abs(read["block"].points - memory["block"].points).max(), 1e-6)

    # A left-handed volume keeps its position.
    def test_left_handed_volume_keeps_position(self):
        axes = np.diag([-1.0, 1, 1])
        volume = turgor.Volume(self.phantom()[:, :, ::-1], (2e-3, 2e-3, 3e-3), (31 * 2e-3, 0, 0), axes)
        plain = turgor.Volume(self.phantom(), (2e-3, 2e-3, 3e-3))
        worlds = [turgor.World(self.scene(v)) for v in (volume, plain)]
        for world in worlds:
            world.step(3)
        np.testing.assert_allclose(worlds[0]["block"].points, worlds[1]["block"].points, atol=1e-7)

    # Volumes of a body are on the grid of the volume in memory, also of a left-handed one.
    def test_volumes_keep_left_handed_grid(self):
        axes = np.array([[-0.8, -0.6, 0], [-0.6, 0.8, 0], [0, 0, 1]])
        samples = self.phantom()
        samples[10, 10, 20:] = 300  # not symmetric along i
        volume = turgor.Volume(samples, (2e-3, 2e-3, 3e-3), (0.07, -0.02, 0.03), axes)
        self.assertLess(np.linalg.det(volume.axes), 0)
        world = turgor.World(self.scene(volume))
        for one in (world, world.copy()):
            body = one["block"]
            for found in (body.volume(), body.deformed_volume()):  # at rest
                np.testing.assert_array_equal(found.samples, volume.samples)
                np.testing.assert_array_equal(found.affine, volume.affine)
        # the same volume in the other order of samples deforms alike
        mirrored = turgor.Volume(samples[:, :, ::-1], volume.spacing, volume.affine[:3] @ [31, 0, 0, 1], axes * [-1, 1, 1])
        other = turgor.World(self.scene(mirrored))
        for one in (world, other):
            one.step(5)
        np.testing.assert_array_equal(world["block"].deformed_volume().samples, other["block"].deformed_volume().samples[:, :, ::-1])
        self.assertFalse(np.array_equal(world["block"].deformed_volume().samples, samples))

    # Labels in memory select the stiffness of tissue.
    def test_labels_in_memory_set_stiffness(self):
        labels = (self.phantom() > 0).astype(np.uint8)
        volume = turgor.Volume(self.phantom(), (2e-3, 2e-3, 3e-3))
        stiff = {"body.block.tissue": {"labels": {"1": 5e6}}}
        sag = []
        for given in ({}, {"labels": {"block": turgor.Volume(labels, (2e-3, 2e-3, 3e-3))}, "set": stiff}):
            world = turgor.World(self.scene(volume), **given)
            world.step(5)
            sag.append(np.abs(world["block"].displacement).max())
        self.assertLess(sag[1], 0.3 * sag[0])
        with self.assertRaisesRegex(turgor.Error, "another grid"):
            turgor.World(self.scene(volume), labels={"block": turgor.Volume(labels, (1e-3, 2e-3, 3e-3))}, set=stiff)

    # Invalid volumes are rejected with a message.
    def test_invalid_volumes_are_rejected(self):
        with self.assertRaisesRegex(turgor.Error, "square to each other"):
            turgor.Volume(self.phantom(), (1, 1, 1), axes=[[1, 0.2, 0], [0, 1, 0], [0, 0, 1]])
        with self.assertRaisesRegex(turgor.Error, r"\(k, j, i\)"):
            turgor.Volume(np.zeros((3, 3)), (1, 1, 1))
        with self.assertRaisesRegex(turgor.Error, "above 0"):
            turgor.Volume(self.phantom(), (1, 0, 1))
        volume = turgor.Volume(self.phantom(), (2e-3, 2e-3, 3e-3))
        with self.assertRaisesRegex(turgor.Error, "missing"):
            turgor.World(self.scene(volume), volumes={"missing": volume})

    # A volume far from the patient is rejected with the name of its body.
    def test_distant_volume_is_rejected(self):
        volume = turgor.Volume(self.phantom(), (2e-3, 2e-3, 3e-3), (0, 1e308, 0))
        with self.assertRaisesRegex(turgor.Error, r"the volume of block: expected samples within 1e\+09 m"):
            turgor.World(self.scene(volume))

    # Numbers of threads that no machine has are rejected.
    def test_thread_numbers_out_of_range_are_rejected(self):
        world = turgor.World(text=PAD, threads=1)
        for threads in (-1, 1025, 100000):
            for call in (lambda: turgor.World(text=PAD, threads=threads), lambda: world.copy(threads), lambda: turgor.run(text=PAD, threads=threads),
                         lambda: turgor.tick_all([world], np.array([[[[0.03, 0.03, 0.05, 1, 0, 0, 0]]]]), threads=threads)):
                with self.assertRaisesRegex(turgor.Error, f"threads from 0 .one per core. to 1024, found {threads}"):
                    call()

    # Numbers and arrays of NumPy, other mappings than dicts and tables with None make the text of plain Python.
    def test_scene_of_numpy_and_mappings_equals_dicts(self):
        size, path = [0.06, 0.05, 0.03], [[0, 0.03, 0.025, 0.04], [0.1, 0.03, 0.025, 0.034]]
        table = types.MappingProxyType
        given = GivenScene(None)
        plain = given.document({"world": {"duration": 0.5, "frame_rate": 50}, "tool": {"finger": {"path": path}},
                                "body": {"pad": {"block": {"size": size, "count": [5, 4, 3]}, "young": 4000.0, "rotations": True, "cache": False}}})
        block = table({"size": np.array(size), "count": np.array([5, 4, 3], np.uint16), "bend": None})
        mixed = given.document(table({
            "world": {"duration": np.array(0.5), "frame_rate": np.uint8(50)}, "tool": {"finger": {"path": np.array(path), "friction": None}},
            "body": table({"pad": table({"block": block, "young": np.float32(4000), "rotations": np.True_, "cache": np.array(False)})})}))
        self.assertEqual(tomllib.loads(mixed), tomllib.loads(plain))
        self.assertEqual(_file_and_text(given, table(tomllib.loads(plain)), None, "in")[1], given.document(tomllib.loads(plain)))

    # A value that TOML does not have is refused with its key.
    def test_values_beyond_toml_are_refused_with_key(self):
        for value, kind in (({1, 2}, "set"), (b"ab", "bytes"), (object(), "object"), (1j, "complex")):
            for scene, overrides in (({"body": {"pad": {"young": value}}}, {}), (None, {"body.pad.young": value}), ({"body": {"pad": {"a": {"b": value}}}}, {})):
                with self.subTest(kind), self.assertRaisesRegex(turgor.Error, rf"^body\.pad\.(young|a\.b): expected a number, a text, a list or a dict, found {kind}$"):
                    turgor.World(scene, text=None if scene else PAD, set=overrides)

    def box(self, height=0.03):
        """Corners and triangles of a box."""
        corners = np.array([[x, y, z] for z in (0, height) for y in (0, 0.05) for x in (0, 0.05)])
        quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
        return corners, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]

    def scene_of_mesh(self, surface):
        return {"body": {"box": {"model": "sfem", "surface": surface, "resolution": 0.012, "fixed": "bottom", "young": 5e3, "cache": False}}}

    # Meshes from arrays become bodies.
    def test_mesh_from_arrays(self):
        corners, triangles = self.box()
        scene = self.scene_of_mesh(turgor.Mesh(corners, triangles))
        world = turgor.World(scene)
        points = world["box"].rest_points
        np.testing.assert_allclose(points.min(axis=0), [0, 0, 0], atol=2e-3)
        np.testing.assert_allclose(points.max(axis=0), [0.05, 0.05, 0.03], atol=2e-3)
        tets = turgor.Mesh([[0, 0, 0], [0.01, 0, 0], [0, 0.01, 0], [0, 0, 0.01], [0.01, 0.01, 0.01]],
                           [[0, 1, 2, 3], [1, 2, 3, 4]])
        scene["body"]["box"] = {"model": "sfem", "mesh": tets, "elements": "linear", "fixed": "bottom", "young": 5e3,
                                "cache": False}
        self.assertEqual(len(turgor.World(scene)["box"].live.rest_vertices), 5)
        with self.assertRaisesRegex(turgor.Error, "0 to 7"):
            turgor.Mesh(corners, [[0, 1, 8]])

    # A saved world with a mesh in memory continues in another world with the same mesh, and in no other one.
    def test_saved_world_of_mesh_continues(self):
        def worlds(mesh):
            yield turgor.World(self.scene_of_mesh(mesh))
            yield turgor.World(self.scene_of_mesh("none.obj"), set={"body.box.surface": mesh})

        corners, triangles = self.box()
        turned = [(b, c, a) for a, b, c in triangles]  # the same surface of other numbers
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "world.state")
            for n in range(2):
                world, again, of_other_mesh, of_higher_box = (
                    list(worlds(turgor.Mesh(*mesh)))[n] for mesh in ((corners, triangles), (corners, triangles), (corners, turned), self.box(0.04)))
                world.step(3)
                world.save(file)
                again.load(file)
                self.assertEqual(again.state_hash, world.state_hash)
                self.assertEqual(again.frame, 3)
                for key in ("scene", "scene_text", "parameters"):
                    self.assertEqual(again.report()[key], world.report()[key])
                for other in (of_other_mesh, of_higher_box):
                    with self.assertRaisesRegex(turgor.Error, "the saved world is of another scene"):
                        other.load(file)
                    self.assertEqual(other.frame, 0)


class Packages(unittest.TestCase):
    def oblique(self):
        a, b = np.deg2rad(17), np.deg2rad(-31)
        turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
        tip = np.array([[1, 0, 0], [0, np.cos(b), -np.sin(b)], [0, np.sin(b), np.cos(b)]])
        samples = np.arange(4 * 5 * 6, dtype=np.int16).reshape(4, 5, 6)
        return turgor.Volume(samples, (0.7e-3, 1.1e-3, 2.5e-3), (0.013, -0.21, 0.37), turn @ tip)

    # An oblique volume is converted to nibabel and back.
    def test_oblique_volume_round_trips_nibabel(self):
        nibabel = _package("nibabel", self)
        volume = self.oblique()
        image = volume.to_nibabel()
        back = turgor.Volume.from_nibabel(image)
        np.testing.assert_array_equal(back.samples, volume.samples)
        np.testing.assert_allclose(back.affine, volume.affine, atol=1e-9)
        index = np.array([3, 1, 2])
        ras = nibabel.affines.apply_affine(image.affine, index)
        lps = volume.affine @ [*index, 1]
        np.testing.assert_allclose(ras * [-1, -1, 1] * 1e-3, lps[:3], atol=1e-9)
        self.assertEqual(np.asarray(image.dataobj)[tuple(index)], volume.samples[2, 1, 3])
        sheared = image.affine.copy()
        sheared[0, 1] += 0.5
        with self.assertRaisesRegex(turgor.Error, "square"):
            turgor.Volume.from_nibabel(nibabel.Nifti1Image(image.dataobj, sheared))

    # An oblique volume is converted to SimpleITK and back.
    def test_oblique_volume_round_trips_simpleitk(self):
        _package("SimpleITK", self)
        volume = self.oblique()
        image = volume.to_sitk()
        back = turgor.Volume.from_sitk(image)
        np.testing.assert_array_equal(back.samples, volume.samples)
        np.testing.assert_allclose(back.affine, volume.affine, atol=1e-9)
        position = np.array(image.TransformIndexToPhysicalPoint((3, 1, 2))) * 1e-3
        np.testing.assert_allclose(position, (volume.affine @ [3, 1, 2, 1])[:3], atol=1e-9)

    # Surfaces convert to PyVista meshes.
    def test_surface_to_pyvista(self):
        _package("pyvista", self)
        world = turgor.World(text=CLOTH)
        world.step(3)
        mesh = world["sheet"].to_pyvista()
        np.testing.assert_allclose(mesh.points, world["sheet"].points)
        self.assertEqual(mesh.n_cells, len(world["sheet"].triangles))
        self.assertIn("displacement [m]", mesh.point_data)

    # Surfaces convert to trimesh meshes.
    def test_surface_to_trimesh(self):
        _package("trimesh", self)
        body = turgor.World(text=FORCEPS)["liver"]
        mesh = body.to_trimesh()
        self.assertTrue(mesh.is_watertight)
        self.assertGreater(mesh.volume, 1e-4)

    # Forces convert to a data frame.
    def test_forces_to_data_frame(self):
        pandas = _package("pandas", self)
        world = turgor.World(text=PAD)
        world.step(2)
        frame = world.forces("finger").frame()
        self.assertIsInstance(frame, pandas.DataFrame)
        self.assertEqual(len(frame), 40)
        self.assertEqual(list(frame.columns)[:4], ["time_s", "position_x_m", "position_y_m", "position_z_m"])


if __name__ == "__main__":
    unittest.main()

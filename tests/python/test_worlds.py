"""Worlds from values: ticks, states, copies and live views."""
import gc
import pathlib
import tempfile
import threading
import unittest

import numpy as np

import turgor
from scenes import CLOTH, FORCEPS, PAD, TORSO


def sliding(ticks, start=0):
    """Poses (ticks, 1, 7) of a finger that presses into the pad and slides over it, so that its patch must follow."""
    time = 1e-3 * (start + 1 + np.arange(ticks))
    poses = np.zeros((ticks, 1, 7))
    poses[:, 0, 0] = 0.012 + 0.15 * time
    poses[:, 0, 1] = 0.03
    poses[:, 0, 2] = 0.0345
    poses[:, 0, 3] = 1
    return poses


class Ticks(unittest.TestCase):
    # Many ticks in one call give the same result as single ticks.
    def test_batched_ticks_match_single_ticks(self):
        together, apart = (turgor.World(text=PAD) for _ in range(2))
        poses = sliding(200)
        forces = together.tick(poses)
        one_by_one = np.concatenate([apart.tick(poses[n:n + 1]) for n in range(200)])
        np.testing.assert_array_equal(forces, one_by_one)
        self.assertEqual(forces.shape, (200, 1, 6))
        self.assertGreater(forces[:, 0, 2].max(), 0.01)
        self.assertEqual(together.state_hash, apart.state_hash)
        self.assertEqual(together.frame, 10)
        np.testing.assert_array_equal(together.forces("finger")["force_N"], forces[:, 0, :3])

    # A ticked tool receives the same force as a tool on the same path.
    def test_ticked_tool_matches_path(self):
        down = [[0, 0.03, 0.03, 0.05], [0.1, 0.03, 0.03, 0.0345]]
        path = turgor.World(text=PAD, set={"tool.finger.path": down})
        path.step(10)
        led = turgor.World(text=PAD)
        poses = np.zeros((200, 1, 7))
        poses[:, 0, :2], poses[:, 0, 3] = 0.03, 1
        poses[:, 0, 2] = 0.05 - 0.0155 * np.minimum((1 + np.arange(200)) / 100, 1)
        actual = led.tick(poses)[:, 0, :3]
        expected = path.forces("finger")["force_N"]
        self.assertGreater(expected[-1, 2], 0.005)
        np.testing.assert_allclose(actual[-1], expected[-1], rtol=1e-3, atol=1e-5)

    # Ticking several worlds together gives the same result as ticking each alone.
    def test_tick_all_matches_single_worlds(self):
        alone = [turgor.World(text=PAD, threads=1) for _ in range(4)]
        together = [turgor.World(text=PAD, threads=1) for _ in range(4)]
        poses = np.stack([sliding(60) + [0, 0, -5e-4 * n, 0, 0, 0, 0] for n in range(4)])
        forces = turgor.tick_all(together, poses, threads=3)
        for world, mine, actual in zip(alone, poses, forces):
            np.testing.assert_array_equal(world.tick(mine), actual)
        self.assertEqual([w.state_hash for w in alone], [w.state_hash for w in together])
        self.assertEqual(len({w.state_hash for w in together}), 4)

    # Other threads run while a world ticks.
    def test_tick_releases_gil(self):
        world = turgor.World(text=PAD, threads=1)
        ticking = threading.Thread(target=world.tick, args=(sliding(400),))
        ticking.start()
        seen = 0
        while ticking.is_alive():
            seen += 1
        ticking.join()
        self.assertGreater(seen, 100)

    # Jaws that hold the tissue receive its pull; open jaws do not.
    def test_holding_jaws_pull_tissue(self):
        path = turgor.World(text=FORCEPS)
        start = path.tool_poses
        path.step(6)
        down = path.forces("forceps")["position_m"]
        poses = np.repeat(start[None], 700, axis=0)
        poses[:, 0, :3] = down[-1]
        poses[:len(down), 0, :3] = down
        poses[450:, 0, 2] += 0.008 * np.linspace(0, 1, 250)  # once the jaws are closed
        pull = []
        for hold in (True, False):
            world = turgor.World(text=FORCEPS)
            actual = world.tick(poses, hold=(np.arange(700)[:, None] > 120) & hold)
            pull.append(actual[450:, 0, 2].min())
        self.assertLess(pull[0], -0.01)  # the tissue pulls the jaws back down
        self.assertGreater(pull[1], -1e-9)

    # Invalid poses are rejected with the index of tick and tool.
    def test_invalid_poses_are_located(self):
        world = turgor.World(text=PAD)
        bad = sliding(3)
        bad[2, 0, 3:] = 0
        with self.assertRaisesRegex(turgor.Error, "tick 2, tool 0"):
            world.tick(bad)
        with self.assertRaisesRegex(turgor.Error, "1 tools, found those of 2"):
            world.tick(np.ones((3, 2, 7)))
        with self.assertRaises((TypeError, ValueError)):
            world.tick(np.ones((3, 1, 6)))
        with self.assertRaisesRegex(turgor.Error, "tick by tick"):
            world.step()

    # is_ticked reports whether a world is ticked; its old name gives a warning.
    def test_is_ticked_and_deprecated_name(self):
        world = turgor.World(text=PAD)
        self.assertFalse(world.is_ticked)
        world.tick(sliding(1))
        self.assertTrue(world.is_ticked)
        with self.assertWarnsRegex(DeprecationWarning, "is now World.is_ticked"):
            self.assertTrue(world.is_led)

    # Old names of scene keys are read with a note.
    def test_old_scene_names_give_note(self):
        bead = {"body.pad.inclusion.bead.centre": [0.03, 0.03, 0.015], "body.pad.inclusion.bead.radius": 0.012}
        world = turgor.World(text=PAD, set=bead)
        self.assertIn('key "centre" is now "center"; the old name is read until the next release', " ".join(world.notes))  # check_words: ok

    # Forces are not recorded if keeps_forces is false.
    def test_forces_are_optional(self):
        world = turgor.World(text=PAD, keeps_forces=False)
        world.tick(sliding(40))
        self.assertEqual(len(world.forces("finger")["time_s"]), 0)


class States(unittest.TestCase):
    # A world that is restored to a state continues with the same bits.
    def test_restored_state_continues_exactly(self):
        world = turgor.World(text=PAD)
        world.tick(sliding(47))
        state, before = world.get_state(), world.state_hash
        first = world.tick(sliding(80, 47))
        after = world.state_hash
        world.set_state(state)
        self.assertEqual(world.state_hash, before)
        np.testing.assert_array_equal(world.tick(sliding(80, 47)), first)
        self.assertEqual(world.state_hash, after)

    # A copy of a world is independent and continues with the same bits.
    def test_copy_is_independent(self):
        for text in (CLOTH, TORSO, FORCEPS):
            world = turgor.World(text=text)
            world.step(3)
            copy, before = world.copy(threads=1), world.state_hash
            copy.step(4)
            self.assertEqual(world.state_hash, before)
            world.step(4)
            self.assertEqual(world.state_hash, copy.state_hash)
            self.assertEqual(copy.bodies, world.bodies)

    # A file is read into the memory of the world: live views show it, and forces go on from its time.
    def test_loaded_file_keeps_views_and_replaces_forces(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "world.state")
            for text, of in ((CLOTH, lambda w: w["sheet"].live.x.z), (CLOTH, lambda w: w["sheet"].live.original),
                             (TORSO, lambda w: w["torso"].live.u.y), (PAD, lambda w: w["pad"].live.rest_vertices)):
                world = turgor.World(text=text)
                world.step(2)
                world.save(file)
                view = of(world)
                kept = view.copy()
                world.step(5)
                world.load(file)
                np.testing.assert_array_equal(view, kept)
                self.assertEqual(view.__array_interface__["data"], of(world).__array_interface__["data"])
            saved, before = world.forces("finger"), world.state_hash
            world.step(3)
            world.load(file)
            self.assertEqual(world.state_hash, before)
            np.testing.assert_array_equal(world.forces("finger")["time_s"], saved["time_s"])
            world.step(3)
            self.assertTrue((np.diff(world.forces("finger")["time_s"]) > 0).all())
            without = turgor.World(text=PAD, keeps_forces=False)
            without.load(file)
            without.step(1)
            self.assertEqual(len(without.forces("finger")["time_s"]), 0)

    # A file keeps the path that a program gave a tool.
    def test_file_keeps_driven_path(self):
        world, fresh = turgor.World(text=PAD), turgor.World(text=PAD)
        world.drive("finger", [[0.1, 0.03, 0.03, 0.0345], [0.2, 0.02, 0.03, 0.0345]])
        world.step(3)
        with tempfile.TemporaryDirectory() as folder:
            world.save(pathlib.Path(folder, "world.state"))
            fresh.load(pathlib.Path(folder, "world.state"))
        for one in (world, fresh):
            one.step(6)
        self.assertEqual(world.state_hash, fresh.state_hash)
        self.assertGreater(world.forces("finger")["force_N"][-1, 2], 0.005)

    # Copies and states of a world after end_touch() have no ticks either.
    def test_copy_after_touch_refuses_ticks(self):
        world = turgor.World(text=PAD)
        world.step()
        before = world.get_state()
        world.begin_touch()
        world.touch_tick(sliding(1)[0])
        world.end_touch()
        copy, after = world.copy(), world.get_state()
        world.set_state(before)
        world.tick(sliding(3))
        world.set_state(after)
        for one in (world, copy, copy.copy()):
            with self.assertRaisesRegex(turgor.Error, "found one with it"):
                one.tick(sliding(1))

    # A state of another world is rejected.
    def test_foreign_state_is_rejected(self):
        with self.assertRaisesRegex(turgor.Error, "another world"):
            turgor.World(text=CLOTH).set_state(turgor.World(text=CLOTH).get_state())


class Views(unittest.TestCase):
    # A live view follows the steps of its world; a copied array does not.
    def test_live_view_follows_steps(self):
        world = turgor.World(text=CLOTH)
        sheet = world["sheet"]
        z, points = sheet.live.x.z, sheet.points
        kept = z.copy()
        world.step(5)
        self.assertLess(z.min(), kept.min() - 1e-4)
        self.assertEqual(points[:, 2].min(), kept.min())
        np.testing.assert_array_equal(np.sort(sheet.points[:, 2]), np.sort(z))

    # A live view keeps its memory when a state is restored.
    def test_live_view_survives_set_state(self):
        for text, of in ((CLOTH, lambda w: w["sheet"].live.x.z), (TORSO, lambda w: w["torso"].live.u.y)):
            world = turgor.World(text=text)
            world.step(1)
            view, state = of(world), world.get_state()
            kept = view.copy()
            world.step(5)  # through a cut
            self.assertFalse(np.array_equal(view, kept))
            world.set_state(state)
            np.testing.assert_array_equal(view, kept)
            self.assertEqual(view.__array_interface__["data"], of(world).__array_interface__["data"])

    # Live views outlive their world and stay writable.
    def test_views_outlive_world(self):
        world = turgor.World(text=TORSO)
        world.step(4)
        u = world["torso"].live.u
        seen = np.array(u.x)
        y = u.y
        del world, u
        gc.collect()
        others = [turgor.World(text=TORSO) for _ in range(2)]  # freed memory would be reused by these
        self.assertEqual(len(others), 2)
        self.assertGreater(np.abs(y).max(), 0)
        self.assertEqual(seen.ndim, 4)
        y[...] = 1.0
        self.assertEqual(y.min(), 1.0)

    # The live view of a lattice is the array of its nodes; writing moves the body.
    def test_lattice_view_is_node_array(self):
        world = turgor.World(text=TORSO)
        torso = world["torso"]
        u = torso.live.u
        before = torso.displacement
        u.x[...] = 0.003
        u.y[...] = 0
        u.z[...] = 0
        np.testing.assert_allclose(torso.displacement[:, 0], 0.003, atol=1e-6)
        self.assertEqual(np.abs(before).max(), 0)
        k, j, parity, half = u.x.shape
        self.assertEqual((k, j, parity, half), (21, 25, 2, 17))  # 33 nodes a row: the last odd node does not exist

    # Views of constant data are read-only, and missing views are errors.
    def test_constant_views_are_read_only(self):
        world = turgor.World(text=PAD)
        vertices = world["pad"].live.rest_vertices
        self.assertEqual(vertices.shape, (7 * 7 * 4, 3))
        np.testing.assert_allclose(vertices.max(axis=0), [0.06, 0.06, 0.03])
        with self.assertRaises(ValueError):
            vertices[0, 0] = 1
        with self.assertRaisesRegex(AttributeError, "lattice"):
            world["pad"].live.u


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
                         lambda: turgor.tick_all([world], sliding(1)[None], threads=threads)):
                with self.assertRaisesRegex(turgor.Error, f"threads from 0 .one per core. to 1024, found {threads}"):
                    call()

    # Meshes from arrays become bodies.
    def test_mesh_from_arrays(self):
        corners = np.array([[x, y, z] for z in (0, 0.03) for y in (0, 0.05) for x in (0, 0.05)])
        quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
        triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
        scene = {"body": {"box": {"model": "sfem", "surface": turgor.Mesh(corners, triangles), "resolution": 0.012,
                                  "fixed": "bottom", "young": 5e3, "cache": False}}}
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


def _package(name, test):
    try:
        return __import__(name)
    except ImportError:
        test.skipTest(f"{name} is not installed")


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


class Runs(unittest.TestCase):
    # A callback stops a run.
    def test_callback_stops_run(self):
        world = turgor.World(text=CLOTH)
        seen = [w.frame for w in world.run(every=0.04, callback=lambda w: w.frame < 4)]
        self.assertEqual(seen, [2, 4])

    # A run into a folder can be stopped or cancelled; a cancelled run leaves no folder.
    def test_run_into_folder_can_be_stopped(self):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder) / "out"
            report = turgor.run(text=FORCEPS, out=out, on_frame=lambda seconds: seconds < 0.1)
            self.assertIn("stopped after 0.1", report["stopped"])
            self.assertTrue((out / "report.json").exists())

            def cancel(seconds):
                if seconds > 0.05:
                    raise KeyboardInterrupt

            with self.assertRaises(KeyboardInterrupt):
                turgor.run(text=FORCEPS, out=pathlib.Path(folder) / "none", on_frame=cancel)
            self.assertEqual([p.name for p in pathlib.Path(folder).iterdir()], ["out"])

    # Progress is reported, and exceptions of the callback propagate.
    def test_progress_exceptions_propagate(self):
        calls = []
        turgor.World(text=TORSO, progress=lambda word, fraction: calls.append((word, fraction)))
        self.assertIn("reading", {word for word, _ in calls})

        def fail(word, fraction):
            raise OSError("disk full")

        with self.assertRaisesRegex(OSError, "disk full"):
            turgor.World(text=TORSO, progress=fail)

    # Measures match the report.
    def test_measures_match_report(self):
        world = turgor.World(text=TORSO)
        for _ in world.run():
            pass
        wound = world.measures("midline")
        self.assertGreater(len(wound["time_s"]), 5)
        report = world.report()
        self.assertAlmostEqual(1e3 * wound["gape_max_m"][-1], report["wounds"][0]["gape_max_mm"], places=4)
        self.assertEqual(report["state_hash"], world.state_hash)
        self.assertIn("sheet", turgor.World(text=CLOTH).measures())


if __name__ == "__main__":
    unittest.main()

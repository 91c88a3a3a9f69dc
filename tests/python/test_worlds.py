"""Worlds in steps and ticks: states, copies, files, threads and live views."""
import gc
import pathlib
import sys
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


def others_run(call, times=1):
    """True if another thread gets the interpreter while `call` is repeated. Only a release of the lock gives it away."""
    ended = []

    def repeat():
        for _ in range(times):
            call()
        ended.append(True)

    repeating = threading.Thread(target=repeat)
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1000)
    try:
        repeating.start()
        ran = not ended
    finally:
        sys.setswitchinterval(interval)
    repeating.join()
    return ran


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

    # Poses of another number of worlds change no world.
    def test_tick_all_refuses_other_number_of_worlds(self):
        worlds = [turgor.World(text=PAD, threads=1) for _ in range(2)]
        before = [world.state_hash for world in worlds]
        for count in (0, 1, 4):
            poses = np.stack([sliding(20)] * count) if count else np.zeros((0, 20, 1, 7))
            with self.assertRaisesRegex(ValueError, f"tick_all: expected poses of 2 worlds, found those of {count}"):
                turgor.tick_all(worlds, poses)
        self.assertEqual([world.state_hash for world in worlds], before)
        self.assertEqual([world.is_ticked for world in worlds], [False, False])

    # Other threads run while a world ticks.
    def test_tick_releases_gil(self):
        world = turgor.World(text=PAD, threads=1)
        self.assertTrue(others_run(lambda: world.tick(sliding(400))))
        self.assertFalse(others_run(lambda: [world.time for _ in range(1000)]))

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

    # Other threads run while a world is copied, saved and loaded, and while its state is read and restored.
    def test_copies_and_files_release_gil(self):
        world = turgor.World(text=TORSO, threads=1)
        world.step(2)
        state = world.get_state()
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "world.state")
            for call in (world.copy, world.get_state, lambda: world.set_state(state), lambda: world.save(file), lambda: world.load(file)):
                self.assertTrue(others_run(call, times=50))

    # A world that another thread steps is not copied, and its state is not read.
    def test_stepped_world_is_not_copied(self):
        world = turgor.World(text=CLOTH, threads=1)
        stepping = threading.Thread(target=lambda: [world.step(20) for _ in range(20)])
        stepping.start()
        refused = 0
        while stepping.is_alive():
            for call in (world.copy, world.get_state):
                try:
                    call()
                except RuntimeError as error:
                    self.assertIn("in a call of another thread", str(error))
                    refused += 1
        stepping.join()
        self.assertGreater(refused, 0)

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
            with self.assertRaisesRegex(turgor.Error, "haptic session has ended"):
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


if __name__ == "__main__":
    unittest.main()

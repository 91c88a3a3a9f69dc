"""Ticks on a thread beside frames: turgor.live and the calls of a world that it uses."""
import pathlib
import tempfile
import threading
import unittest

import numpy as np

import turgor
from scenes import CLOTH, PAD
from turgor.live import LiveWorld, overrides

BALL = """[tool.ball]
body = "sheet"
shape = { sphere = 0.01 }
path = [[0, 0.1, 0.1, 0.05], [1, 0.1, 0.1, 0.15]]
"""


class Overrides(unittest.TestCase):
    # KEY= removes a key, as for the program.
    def test_empty_value_removes_key(self):
        self.assertEqual(overrides(["body.liver.inside=", "a.b=2", "a.c=x y"]),
                         {"body.liver.inside": None, "a.b": 2, "a.c": "x y"})


class Touch(unittest.TestCase):
    # Ticks go on while a frame waits for them: neither thread waits for the other.
    def test_ticks_do_not_wait_for_frames(self):
        live = LiveWorld(turgor.World(text=PAD, keeps_forces=False))
        went_on = threading.Event()
        begun, seen = [], []

        def on_frame():
            if not begun:
                begun.append(live.ticks)
                seen.append(went_on.wait(60))
                live.stops = True

        def on_tick(wrench):
            if begun and live.ticks >= begun[0] + 100:
                went_on.set()

        live.run(None, on_tick, on_frame)
        self.assertEqual(seen, [True])
        self.assertGreaterEqual(live.world.frame, 1)

    # With the frames between the same ticks, forces have the bits of World.tick.
    def test_touch_has_bits_of_tick(self):
        poses = np.repeat([[[0.03, 0.03, 0.05, 1, 0, 0, 0]]], 120, axis=0)
        poses[:, 0, 2] = np.linspace(0.05, 0.032, 120)
        alone = turgor.World(text=PAD)
        expected = alone.tick(poses)
        world = turgor.World(text=PAD)
        world.begin_touch()
        found = []
        for n, pose in enumerate(poses):
            force, used = world.touch_tick(pose)
            np.testing.assert_allclose(used, pose, atol=1e-12)
            found.append(force)
            while (world.frame + 1) * world.dt <= (n + 1) * 1e-3 + 1e-9:
                world.step()
        np.testing.assert_array_equal(np.array(found), expected)
        self.assertGreater(expected[-1, 0, 2], 0.01)
        world.end_touch()
        np.testing.assert_array_equal(world["pad"].points, alone["pad"].points)

    # Gaps are counted, and their quantiles are those of the list.
    def test_gaps_between_wrenches(self):
        live = LiveWorld(turgor.World(text=PAD, keeps_forces=False))
        self.assertEqual(live.gap(0.5), 0)
        gaps = np.random.default_rng(1).uniform(0.5e-3, 5e-3, 1000)
        for gap in gaps:
            live._count_gap(gap)
        for share in (0.5, 0.99, 1):
            self.assertAlmostEqual(live.gap(share), np.quantile(gaps, share, method="inverted_cdf"), delta=2e-5)
        self.assertEqual(live.longest_gap, gaps.max())
        live = LiveWorld(turgor.World(text=PAD, keeps_forces=False))
        live.run(0.1)
        self.assertGreater(live.gaps.sum(), 0)
        self.assertLessEqual(live.gaps.sum(), 99)
        self.assertIn("p99", live.summary())

    # A row of NaN moves its tool along the path of the scene.
    def test_row_of_nan_follows_path(self):
        world, other = turgor.World(text=PAD), turgor.World(text=PAD)
        world.begin_touch()
        for _ in range(80):
            _, used = world.touch_tick(np.full((1, 7), np.nan))
        other.step(4)
        self.assertAlmostEqual(other.time, 0.08)
        np.testing.assert_allclose(used, other.tool_poses, atol=1e-9)

    # On cloth too, a row of NaN and tool_poses follow the path, after the tool was led elsewhere and beside frames.
    def test_tool_on_cloth_returns_to_path(self):
        world = turgor.World(text=CLOTH + BALL)
        path = turgor.World(text=CLOTH + BALL)
        world.begin_touch()
        for n in range(100):
            goal = [[0.02, 0.02, 0.05, 1, 0, 0, 0]] if n < 60 else np.full((1, 7), np.nan)
            _, used = world.touch_tick(goal)
            if n % 20 == 19:
                world.step()
        path.step(5)
        np.testing.assert_allclose(used, path.tool_poses, atol=1e-9)
        np.testing.assert_allclose(world.tool_poses, path.tool_poses, atol=1e-9)
        self.assertGreater(used[0, 2], 0.052)

    def test_calls_in_wrong_order_are_refused(self):
        world = turgor.World(text=PAD)
        pose = world.tool_poses
        for call in (lambda: world.touch_tick(pose), world.end_touch):
            with self.assertRaisesRegex(turgor.Error, "expected an earlier begin_touch"):
                call()
        world.begin_touch()
        for call in (world.get_state, world.copy, world.report, lambda: world.state_hash, lambda: world.tick(pose[None])):
            with self.assertRaisesRegex(turgor.Error, "before begin_touch"):
                call()
        with self.assertRaisesRegex(turgor.Error, "found one with earlier ticks"):
            world.begin_touch()
        with self.assertRaisesRegex(ValueError, "touch_tick: expected poses"):
            world.touch_tick(pose[0])
        world.step()
        world.end_touch()

    # After end_touch() no call sends to another one that is refused; the state from before begin_touch() goes on.
    def test_ended_session_names_way_back(self):
        world = turgor.World(text=PAD)
        world.step()
        before, pose = world.get_state(), world.tool_poses
        path = [[0.1, 0.03, 0.03, 0.04]]
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "world.state")
            calls = {"step()": world.step, "tick()": lambda: world.tick(pose[None]), "drive()": lambda: world.drive("finger", path),
                     "save()": lambda: world.save(file), "load()": lambda: world.load(file), "begin_touch()": world.begin_touch}
            world.begin_touch()
            for name in ("tick()", "drive()", "save()", "load()"):
                with self.assertRaisesRegex(turgor.Error, rf"expected {name[:-2]}\(\) before begin_touch\(\), found it after"):
                    calls[name]()
            world.step()
            world.end_touch()
            for name, call in calls.items():
                with self.assertRaisesRegex(turgor.Error, rf"^{name[:-2]}\(\): expected a new world, or set_state\(\) with a state from before "
                                                          r"begin_touch\(\), found a world whose haptic session has ended$"):
                    call()
            world.set_state(before)
            for name in ("save()", "load()", "step()", "drive()", "tick()"):
                calls[name]()

    # What a frame raises ends the run and is raised by it.
    def test_error_of_frame_is_raised(self):
        def on_frame():
            raise ZeroDivisionError("of a frame")

        with self.assertRaisesRegex(ZeroDivisionError, "of a frame"):
            LiveWorld(turgor.World(text=PAD, keeps_forces=False)).run(None, on_frame=on_frame)


if __name__ == "__main__":
    unittest.main()

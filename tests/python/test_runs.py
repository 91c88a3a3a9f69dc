"""Runs of worlds, and into folders: their ends, progress and measures."""
import pathlib
import tempfile
import unittest

import numpy as np

import turgor
from scenes import CLOTH, FORCEPS, PAD, TORSO, hash_of_program


class Runs(unittest.TestCase):
    # A run has the frames of the program: those of the duration, rounded to whole frames with halves upwards, and at least one.
    def test_run_has_frames_of_program(self):
        for duration, frames in ((0.25, 13), (0.21, 11), (0.005, 1)):
            text = PAD.replace("duration = 0.2\n", f"duration = {duration}\n")
            self.assertIn(f"duration = {duration}\n", text)
            world = turgor.World(text=text)
            moments = [moment.frame for moment in world.run(every=0.1)]
            self.assertEqual(world.frame, frames)
            self.assertEqual(moments, [*range(5, frames, 5), frames])
            self.assertEqual(world.state_hash, hash_of_program(text))
            self.assertEqual(list(world.run()), [])
        world = turgor.World(text=PAD)
        self.assertEqual([moment.frame for moment in world.run(seconds=0.25, every=0.05)], [3, 6, 9, 12, 13])
        with self.assertRaisesRegex(ValueError, "expected seconds of at least 0, found inf"):
            world.run(seconds=float("inf"))
        self.assertEqual([moment.frame for moment in world.run(seconds=0.04, every=float("inf"))], [15])

    # A callback stops a run.
    def test_callback_stops_run(self):
        world = turgor.World(text=CLOTH)
        seen = [w.frame for w in world.run(every=0.04, callback=lambda w: w.frame < 4)]
        self.assertEqual(seen, [2, 4])

    # False of Python and of NumPy end a run; other answers of a callback do not.
    def test_only_false_ends_run(self):
        for answer, ends in ((False, True), (np.False_, True), (True, False), (np.True_, False), (None, False), (0, False), ("", False),
                             (np.int64(0), False), (np.zeros(2), False)):
            with self.subTest(answer=repr(answer)), tempfile.TemporaryDirectory() as folder:
                world = turgor.World(text=CLOTH)
                frames = [w.frame for w in world.run(seconds=0.08, every=0.04, callback=lambda w: answer)]
                self.assertEqual(frames, [2] if ends else [2, 4])
                report = turgor.run(text=CLOTH.replace("duration = 0.2", "duration = 0.04"), out=pathlib.Path(folder) / "out", on_frame=lambda seconds: answer)
                self.assertEqual("stopped after 0.02" in report.get("stopped", ""), ends, report.get("stopped"))

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

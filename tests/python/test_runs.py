"""Runs of worlds, and into folders: their ends, progress and measures."""
import pathlib
import tempfile
import unittest

import turgor
from scenes import CLOTH, FORCEPS, TORSO


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

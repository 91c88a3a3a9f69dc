"""The Python module compared with the program. scripts/python sets TURGOR (the program) and PYTHONPATH."""
import os
import pathlib
import tempfile
import threading
import unittest

import numpy as np

import turgor
from scenes import CLOTH, FORCEPS, PAD, TORSO, hash_of_program
from turgor.engine import choose, processor_flags


class Turgor(unittest.TestCase):
    # Every model gives the same state as the program.
    def test_models_match_program(self):
        for text in (FORCEPS, PAD, CLOTH, TORSO):
            world = turgor.World(text=text, threads=2)
            for _ in world.run():
                pass
            self.assertEqual(world.state_hash, hash_of_program(text), text)

    # A run gives the state of the program and writes its folder.
    def test_run_matches_program_and_writes_folder(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = pathlib.Path(folder) / "s.toml"
            scene.write_text(FORCEPS)
            report = turgor.run(scene, out=pathlib.Path(folder) / "out", set={"world.duration": 0.2})
            self.assertEqual(report["state_hash"], hash_of_program(FORCEPS, "--set", "world.duration=0.2"))
            self.assertTrue((pathlib.Path(folder) / "out/report.html").exists())

    # Points are rest points plus displacements.
    def test_points_are_rest_plus_displacement(self):
        world = turgor.World(text=CLOTH)
        world.step(5)
        sheet = world["sheet"]
        self.assertEqual(sheet.rest_points.shape, (len(sheet.points), 3))
        np.testing.assert_allclose(sheet.rest_points + sheet.displacement, sheet.points, atol=1e-6)
        self.assertLess(sheet.displacement[:, 2].min(), -1e-3)
        self.assertEqual(sheet.triangles.min(), 0)
        self.assertEqual(sheet.triangles.max(), len(sheet.points) - 1)

    # The report names the highest instruction set of the processor.
    @unittest.skipUnless(os.uname().machine == "x86_64", "another processor")
    def test_report_names_instruction_set(self):
        highest = f"x86-64-{choose(None, processor_flags())}"
        self.assertEqual(turgor.World(text=CLOTH).report()["machine"]["instructions"], highest)
        self.assertEqual(turgor.instructions, highest)

    # The walls of a wound are the last triangles and appear with the cut.
    def test_wound_walls_are_last_triangles(self):
        world = turgor.World(text=TORSO)
        torso = world["torso"]
        self.assertEqual(torso.wall_begin, len(torso.triangles))
        world.step(10)
        self.assertLess(torso.wall_begin, len(torso.triangles))
        inside = torso.rest_points[torso.triangles[torso.wall_begin:]].mean(axis=(0, 1))
        np.testing.assert_allclose(inside[[0, 2]], [0, 0], atol=0.02)  # under the middle of the cut
        self.assertEqual(turgor.World(text=CLOTH)["sheet"].wall_begin, len(turgor.World(text=CLOTH)["sheet"].triangles))

    # Arrays outlive their world and do not change.
    def test_arrays_outlive_world(self):
        world = turgor.World(text=CLOTH)
        before = world["sheet"].points
        kept = before.copy()
        world.step(3)
        del world
        np.testing.assert_array_equal(before, kept)

    # A driven tool gives the same force as a path in the scene.
    def test_driven_tool_matches_scene_path(self):
        driven = turgor.World(text=PAD)
        rows = np.array([[0.1, 0.03, 0.03, 0.0345], [0.2, 0.03, 0.03, 0.0345]])
        driven.drive("finger", rows)
        written = turgor.World(text=PAD, set={
            "tool.finger.path": [[0, 0.03, 0.03, 0.05], [0.1, 0.03, 0.03, 0.0345], [0.2, 0.03, 0.03, 0.0345]]})
        for world in (driven, written):
            for _ in world.run():
                pass
        actual, expected = driven.forces("finger"), written.forces("finger")
        self.assertGreater(expected["force_N"][-1, 2], 0.005)
        np.testing.assert_allclose(actual["force_N"][-1], expected["force_N"][-1], atol=1e-6)
        line = 0.05 - 0.0155 * np.minimum(actual["time_s"] / 0.1, 1)
        np.testing.assert_allclose(actual["position_m"][:, 2], line, atol=1e-12)

    # What the program rejects raises an error with the same message.
    def test_errors_have_messages_of_program(self):
        with self.assertRaisesRegex(turgor.Error, "tension"):
            turgor.World(text=TORSO, set={"body.torso.skin.tension": -4})
        with self.assertRaisesRegex(turgor.Error, "no-such.toml"):
            turgor.World("no-such.toml")
        with self.assertRaisesRegex(KeyError, "spleen"):
            turgor.World(text=CLOTH)["spleen"]
        with self.assertRaisesRegex(turgor.Error, "row"):
            turgor.World(text=PAD).drive("finger", np.array([[0.1, 2.0]]))
        with self.assertRaises(TypeError):
            turgor.World()
        with self.assertRaisesRegex(turgor.Error, "ct"):
            turgor.World({"body": {"torso": {"model": "lattice", "fixed": ["bone"]}}})

    # Overrides accept dictionaries, NumPy scalars and None.
    def test_overrides_accept_python_values(self):
        world = turgor.World(text=FORCEPS, set={"body.liver.surface": {"phantom": "liver", "detail": 0.25},
                                                "world.duration": np.float64(0.1), "output.video": None})
        self.assertAlmostEqual(world.duration, 0.1)

    # Worlds run concurrently in threads; entering one world twice is an error.
    def test_threads_share_no_world(self):
        worlds = [turgor.World(text=CLOTH, threads=1) for _ in range(4)]
        threads = [threading.Thread(target=world.step, args=(10,)) for world in worlds]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(len({world.state_hash for world in worlds}), 1)
        one = turgor.World(text=CLOTH, threads=1)
        refused = []

        def enter():
            try:
                for _ in range(20):
                    one.step(20)
            except RuntimeError as error:
                refused.append(str(error))

        threads = [threading.Thread(target=enter) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertTrue(refused and "another thread" in refused[0])

    # Access to a world that another thread is stepping is an error.
    def test_stepping_world_rejects_access(self):
        world = turgor.World(text=TORSO, threads=1)
        looks = [lambda: world["torso"], lambda: world.state_hash, lambda: world.time, lambda: world.notes,
                 lambda: world.tools, lambda: world.bodies]
        stepping = threading.Thread(target=world.step, args=(300,))
        stepping.start()
        refused = 0
        while stepping.is_alive() and refused < len(looks):
            try:
                looks[refused]()
            except RuntimeError as error:
                self.assertIn("another thread", str(error))
                refused += 1
        stepping.join()
        self.assertEqual(refused, len(looks))
        self.assertEqual(world.frame, 300)

    # Texts may contain any Unicode character.
    def test_texts_may_be_unicode(self):
        with self.assertRaisesRegex(turgor.Error, "\U0001d6d1.nii"):
            turgor.World(text=TORSO, set={"body.torso.ct": "/no-such-folder/\U0001d6d1.nii"})


if __name__ == "__main__":
    unittest.main()

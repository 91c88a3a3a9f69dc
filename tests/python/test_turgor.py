"""The Python module against the program: TURGOR (the program) and PYTHONPATH come from scripts/python."""
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
    def test_every_model_has_the_programs_bits(self):
        for text in (FORCEPS, PAD, CLOTH, TORSO):
            world = turgor.World(text=text, threads=2)
            for _ in world.run():
                pass
            self.assertEqual(world.state_hash, hash_of_program(text), text)

    def test_a_run_is_the_programs_and_leaves_its_folder(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = pathlib.Path(folder) / "s.toml"
            scene.write_text(FORCEPS)
            report = turgor.run(scene, out=pathlib.Path(folder) / "out", set={"world.duration": 0.2})
            self.assertEqual(report["state_hash"], hash_of_program(FORCEPS, "--set", "world.duration=0.2"))
            self.assertTrue((pathlib.Path(folder) / "out/report.html").exists())

    def test_places_are_rest_and_displacement(self):
        world = turgor.World(text=CLOTH)
        world.step(5)
        sheet = world["sheet"]
        self.assertEqual(sheet.rest_points.shape, (len(sheet.points), 3))
        np.testing.assert_allclose(sheet.rest_points + sheet.displacement, sheet.points, atol=1e-6)
        self.assertLess(sheet.displacement[:, 2].min(), -1e-3)
        self.assertEqual(sheet.triangles.min(), 0)
        self.assertEqual(sheet.triangles.max(), len(sheet.points) - 1)

    @unittest.skipUnless(os.uname().machine == "x86_64", "another processor")
    def test_the_report_names_all_instructions_that_this_processor_has(self):
        highest = f"x86-64-{choose(None, processor_flags())}"
        self.assertEqual(turgor.World(text=CLOTH).report()["machine"]["instructions"], highest)
        self.assertEqual(turgor.instructions, highest)

    def test_walls_of_a_wound_are_the_last_triangles_and_come_with_the_cut(self):
        world = turgor.World(text=TORSO)
        torso = world["torso"]
        self.assertEqual(torso.wall_begin, len(torso.triangles))
        world.step(10)
        self.assertLess(torso.wall_begin, len(torso.triangles))
        inside = torso.rest_points[torso.triangles[torso.wall_begin:]].mean(axis=(0, 1))
        np.testing.assert_allclose(inside[[0, 2]], [0, 0], atol=0.02)  # under the middle of the cut
        self.assertEqual(turgor.World(text=CLOTH)["sheet"].wall_begin, len(turgor.World(text=CLOTH)["sheet"].triangles))

    def test_arrays_outlive_their_world_and_do_not_change(self):
        world = turgor.World(text=CLOTH)
        before = world["sheet"].points
        kept = before.copy()
        world.step(3)
        del world
        np.testing.assert_array_equal(before, kept)

    def test_a_driven_tool_presses_where_it_is_led_as_hard_as_a_path_of_the_scene(self):
        driven = turgor.World(text=PAD)
        rows = np.array([[0.1, 0.03, 0.03, 0.0345], [0.2, 0.03, 0.03, 0.0345]])
        driven.drive("finger", rows)
        written = turgor.World(text=PAD, set={
            "tool.finger.path": [[0, 0.03, 0.03, 0.05], [0.1, 0.03, 0.03, 0.0345], [0.2, 0.03, 0.03, 0.0345]]})
        for world in (driven, written):
            for _ in world.run():
                pass
        felt, expected = driven.forces("finger"), written.forces("finger")
        self.assertGreater(expected["force_N"][-1, 2], 0.005)
        np.testing.assert_allclose(felt["force_N"][-1], expected["force_N"][-1], atol=1e-6)
        line = 0.05 - 0.0155 * np.minimum(felt["time_s"] / 0.1, 1)
        np.testing.assert_allclose(felt["position_m"][:, 2], line, atol=1e-12)

    def test_what_the_program_refuses_is_an_error_with_its_sentence(self):
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

    def test_overrides_are_written_as_toml(self):
        world = turgor.World(text=FORCEPS, set={"body.liver.surface": {"phantom": "liver", "detail": 0.25},
                                                "world.duration": np.float64(0.1), "output.video": None})
        self.assertAlmostEqual(world.duration, 0.1)

    def test_worlds_run_beside_each_other_and_one_world_is_entered_once(self):
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

    def test_a_world_that_is_being_stepped_is_not_looked_at(self):
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

    def test_a_text_is_any_text(self):
        with self.assertRaisesRegex(turgor.Error, "\U0001d6d1.nii"):
            turgor.World(text=TORSO, set={"body.torso.ct": "/no-such-folder/\U0001d6d1.nii"})


if __name__ == "__main__":
    unittest.main()

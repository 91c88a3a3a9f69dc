"""Every shipped scene in Python: the state of the program after the same frames."""
import pathlib
import tempfile
import tomllib
import unittest

import turgor
from scenes import state_of_program

SOURCE = pathlib.Path(__file__).parents[2]


def golden_lines():
    """Scenes with a few frames and with overrides that make them small, from the table of golden states."""
    for line in (SOURCE / "tests/golden/states.txt").read_text().splitlines():
        if line and not line.startswith("#"):
            _, scene, frames, *overrides = line.split()
            yield SOURCE / "scenes" / scene, int(frames), overrides


class Scenes(unittest.TestCase):
    # Every scene gives the same state as the program.
    def test_scenes_match_program(self):
        for file, frames, overrides in golden_lines():
            with self.subTest(scene=file.name), tempfile.TemporaryDirectory() as folder:
                rate = tomllib.loads(file.read_text())["world"].get("frame_rate", 60)
                set = dict(o.split("=", 1) for o in overrides)
                set = {key: tomllib.loads(f"v = {value}")["v"] for key, value in set.items()}
                world = turgor.World(file, set=set)
                world.step(frames)
                self.assertEqual(world.state_hash, state_of_program(file, frames / rate, overrides, folder))

    # A scene as a dictionary gives the same state as its file.
    def test_dict_scene_matches_file(self):
        file = SOURCE / "scenes/flag.toml"
        as_dict = turgor.World(tomllib.loads(file.read_text()), folder=file.parent)
        as_file = turgor.World(file)
        as_dict.step(3)
        as_file.step(3)
        self.assertEqual(as_dict.state_hash, as_file.state_hash)


if __name__ == "__main__":
    unittest.main()

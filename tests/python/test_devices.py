"""Presets of haptic devices: the tables of docs/devices.md, and a run in real time with the limits of a device."""
import importlib.machinery
import importlib.util
import json
import pathlib
import re
import subprocess
import tempfile
import unittest

import turgor
from scenes import PAD, PROGRAM

ROOT = pathlib.Path(__file__).resolve().parents[2]
LOADER = importlib.machinery.SourceFileLoader("device_table", str(ROOT / "scripts/device-table"))
table = importlib.util.module_from_spec(importlib.util.spec_from_loader("device_table", LOADER))
LOADER.exec_module(table)

# A pad of rubber, pressed by 2 mm.
RUBBER = {"body.pad.young": 2e6, "tool.finger.path": [[0, 0.03, 0.03, 0.045], [0.3, 0.03, 0.03, 0.034], [0.5, 0.03, 0.03, 0.034]],
          "world.duration": 1.6}


def block_of(page, name):
    return re.search(f"<!-- {name} -->\n(.*?)<!-- end -->", page, re.S).group(1)


class Tables(unittest.TestCase):
    # The presets of the page are those of the program, and each verdict follows from the numbers of its row.
    def test_tables_follow_from_presets_and_numbers(self):
        page = table.PAGE.read_text(encoding="utf-8")
        self.assertEqual(len(table.presets()), 8)
        self.assertEqual(block_of(page, "presets"), table.preset_table())
        rows = re.findall(r"^\| (.*?) \| `?(.*?)(?:\.toml`)? \| (\S+) N \| (\S+) N/m \| (\S+) mm \| .*\|$", block_of(page, "scenes that fit"), re.M)
        self.assertEqual([row[:2] for row in rows], table.SCENES)
        again = [table.scene_row(caption, scene, *map(float, numbers)) for caption, scene, *numbers in rows]
        self.assertEqual(block_of(page, "scenes that fit"), table.scene_table(again))


class Limits(unittest.TestCase):
    def report(self, *options, **keys):
        with tempfile.TemporaryDirectory() as folder:
            scene = pathlib.Path(folder) / "s.toml"
            scene.write_text(PAD)
            overrides = [text for key, value in {**RUBBER, **keys}.items() for text in ("--set", f"{key}={json.dumps(value)}")]
            subprocess.run([PROGRAM, "run", scene, "-q", "-o", f"{folder}/out", *overrides, *options], check=True)
            return json.loads((pathlib.Path(folder) / "out/report.json").read_text())

    # Without a clock the report compares the tool with the device that the scene names.
    def test_report_compares_tool_with_device(self):
        report = self.report(**{"tool.finger.device": "touch", "world.duration": 0.5})
        tool = report["tools"][0]
        self.assertEqual(tool["device"]["name"], "touch")
        self.assertEqual((tool["device"]["force_N"], tool["device"]["stiffness_N_per_m"]), (3.3, 400))
        self.assertGreater(tool["force_max_N"], 3.3)
        self.assertGreater(tool["device"]["saturated"], 200)
        self.assertFalse(tool["device"]["fits"])
        self.assertAlmostEqual(tool["reach_mm"], 5.5, places=2)
        said = " ".join(report["warnings"])
        self.assertIn("finger: a 3D Systems Touch reaches 3.3 N and would cut off the force", said)
        self.assertIn("renders up to 400 N/m", said)
        # a stiff arm that reaches it all, and a workspace that is too small
        self.assertTrue(self.report(**{"tool.finger.device": "delta.3", "world.duration": 0.5, "body.pad.young": 2e4})["tools"][0]["device"]["fits"])
        far = [[0, 0.03, 0.03, 0.15], [0.4, 0.03, 0.03, 0.05]]
        small = self.report(**{"tool.finger.device": "falcon", "world.duration": 0.5, "tool.finger.path": far})
        self.assertFalse(small["tools"][0]["device"]["fits"])
        self.assertIn("Novint Falcon reaches 40 mm to all sides, and the tool moves 50 mm", " ".join(small["warnings"]))
        self.assertNotIn("device", self.report(**{"world.duration": 0.1})["tools"][0])

    # In real time the simulated hand (300 N/m) aims 26 mm behind the surface. At rest three springs are in series: the hand,
    # the coupling with the device's stiffness, and the pad. A Touch renders 3.3 N of the larger force of its coupling.
    def test_virtual_device_has_limits_of_preset(self):
        # a soft start needs a hand at rest, also if the loop starts late on a busy machine
        deep = [[0, 0.03, 0.03, 0.04], [0.7, 0.03, 0.03, 0.04], [0.9, 0.03, 0.03, 0.01]]
        for device, stiffness, most in (("touch", 400, 3.3), ("falcon", 3000, 8)):
            report = self.report("--real-time", **{"tool.finger.device": device, "tool.finger.path": deep, "world.duration": 2.2})
            _, force, depth = report["tools"][0]["series"][-1][:3]  # s, N, mm
            rendered = min(force, most)
            self.assertAlmostEqual(1e3 * force / stiffness + depth + 1e3 * rendered / 300, 26, delta=0.4)
            saturated = report["haptics"]["safety"]["saturated"]
            self.assertGreater(saturated, 100) if device == "touch" else self.assertEqual(saturated, 0)
        far = [[0, 0.03, 0.03, 0.15], [0.1, 0.03, 0.03, 0.05]]
        falcon = self.report("--real-time", **{"tool.finger.device": "falcon", "tool.finger.path": far, "world.duration": 0.4})
        self.assertIn("the hand was at the end of the workspace", " ".join(falcon["haptics"]["notes"]))

    # An unknown device is refused with the list of known ones.
    def test_unknown_device_is_refused(self):
        with self.assertRaisesRegex(turgor.Error, 'expected "delta.3", .*"touch", found "tuch"; did you mean "touch"'):
            turgor.World(text=PAD, set={"tool.finger.device": "tuch"})


if __name__ == "__main__":
    unittest.main()

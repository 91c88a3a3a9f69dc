# turgor.identify: start values that are far off reach the modulus that made the force.
import unittest

import numpy as np

import turgor

from scenes import PAD_BODY

# The finger goes in by 2 mm within 0.1 s.
PRESS = "[world]\nduration = 0.1\n" + PAD_BODY + """[tool.finger]
body = "pad"
shape = { sphere = 0.012 }
friction = 0
press = { at_fraction = [0.5, 0.5, 1], depth = 0.002, start = 0, duration = 0.1, hold = 0 }
"""
KEY = "body.pad.young"


class Identify(unittest.TestCase):
    # The forces of one modulus, over depth and over time, lead back to it.
    def test_forces_lead_back_to_their_modulus(self):
        pressed = turgor.World(text=PRESS, set={KEY: 7.3e3})
        for _ in pressed.run():
            pass
        curve = pressed.forces("finger")
        force = np.linalg.norm(curve["force_N"], axis=1)
        rows = slice(40, 96, 11)
        for column, name in (("time_s", "time"), ("depth_m", "depth")):
            found = turgor.identify(text=PRESS, fit={KEY: 2e3}, force=force[rows], **{name: curve[column][rows]})
            self.assertTrue(found.converged)
            self.assertAlmostEqual(found.parameters[KEY].value / 7.3e3, 1, delta=2e-3, msg=name)
            self.assertLess(found.residual, 1e-3)
            self.assertEqual(found.force_N.shape, force[rows].shape)
            self.assertAlmostEqual(found.parameters[KEY].sensitivity, 1, delta=0.02)  # linear elastic

    # Columns by the name of the tool are fitted together and give a force by name.
    def test_tools_by_name_are_fitted_together(self):
        second = PRESS + PRESS[PRESS.index("[tool.finger]"):].replace("finger", "thumb").replace("0.012", "0.009").replace("0.5, 0.5", "0.8, 0.5")
        pressed = turgor.World(text=second, set={KEY: 7.3e3})
        for _ in pressed.run():
            pass
        depth, force = {}, {}
        for name in ("finger", "thumb"):
            curve = pressed.forces(name)
            depth[name] = curve["depth_m"][40:96:11]
            force[name] = np.linalg.norm(curve["force_N"], axis=1)[40:96:11]
        found = turgor.identify(text=second, fit={KEY: 2e3}, force=force, depth=depth)
        self.assertAlmostEqual(found.parameters[KEY].value / 7.3e3, 1, delta=2e-3)
        self.assertEqual(len(found.residuals), 2)
        for name in force:
            np.testing.assert_allclose(found.force_N[name], force[name], rtol=5e-3)
        with self.assertRaisesRegex(ValueError, "same tools"):
            turgor.identify(text=second, fit={KEY: 2e3}, force=force, depth={"finger": depth["finger"]})
        with self.assertRaisesRegex(TypeError, "both by the name"):
            turgor.identify(text=second, fit={KEY: 2e3}, force=force, depth=[1e-3])

    # Wrong input is refused with a sentence.
    def test_wrong_input_is_refused(self):
        rows = {"depth": [4e-4, 8e-4, 1.2e-3], "force": [1e-2, 2e-2, 4e-2]}
        for wrong, expected in (({"fit": {KEY: -3}}, "above 0"), ({"fit": {"body.pad.yuong": 3}}, "yuong"),
                                ({"fit": {KEY: 3e3}, "tool": "none"}, "a tool named none"),
                                ({"fit": {KEY: 3e3}, "depth": [4e-4, 8e-4, 0.05]}, "the tool finger"),
                                ({"fit": {KEY: 3e3}, "threads": 5000}, "1024")):
            with self.assertRaisesRegex(turgor.Error, expected):
                turgor.identify(text=PRESS, **{**rows, **wrong})
        with self.assertRaisesRegex(ValueError, "rows"):
            turgor.identify(text=PRESS, fit={KEY: 3e3}, depth=[1e-3], force=[1, 2])
        with self.assertRaisesRegex(TypeError, "depth= or time="):
            turgor.identify(text=PRESS, fit={KEY: 3e3}, force=[1, 2])


if __name__ == "__main__":
    unittest.main()

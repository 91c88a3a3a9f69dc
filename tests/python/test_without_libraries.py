"""Bridges to other programs without the library that speaks their protocol."""
import subprocess
import sys
import unittest


class WithoutLibraries(unittest.TestCase):
    # A bridge is refused with the command that installs its library.
    def test_bridges_name_their_library(self):
        for bridge, library in (("openigtlink", "pyigtl"), ("ros2", "cyclonedds")):
            with self.subTest(bridge=bridge):
                script = (f"import sys; sys.modules['{library}'] = None; from turgor import {bridge}\n"
                          f"try: {bridge}.Bridge(None)\nexcept {bridge}.Error as error: print(error)")
                done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
                self.assertIn(f"expected {library}, found none; pip install {library}", done.stdout, done.stderr)


if __name__ == "__main__":
    unittest.main()

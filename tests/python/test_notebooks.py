"""The notebooks of docs/notebooks, executed cell by cell; what they claim they assert."""
import json
import pathlib
import unittest

try:
    import matplotlib
    import matplotlib.pyplot
except ImportError:
    matplotlib = None

FOLDER = pathlib.Path(__file__).parents[2] / "docs/notebooks"


def code_of(file):
    return ["".join(cell["source"]) for cell in json.loads(file.read_text())["cells"] if cell["cell_type"] == "code"]


@unittest.skipUnless(matplotlib, "matplotlib is not installed")
class Notebooks(unittest.TestCase):
    # Every notebook runs to its end.
    def test_notebooks_run(self):
        matplotlib.use("Agg")
        files = sorted(FOLDER.glob("*.ipynb"))
        self.assertEqual(len(files), 3)
        for file in files:
            with self.subTest(file.name):
                names = {}
                for number, code in enumerate(code_of(file)):
                    exec(compile(code, f"{file.name}, code cell {number}", "exec"), names)
                matplotlib.pyplot.close("all")


if __name__ == "__main__":
    unittest.main()

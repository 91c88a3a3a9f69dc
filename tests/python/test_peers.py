"""The comparison with peers (benches/peers): its work, its ratios and its rows, without the peers."""
import pathlib
import subprocess
import sys
import tempfile
import types
import unittest

import numpy as np

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "benches/peers"
sys.path.insert(0, str(FOLDER))
import table  # noqa: E402
import work  # noqa: E402


def options(**changes):
    return types.SimpleNamespace(**{"threads": 1, "rounds": 2, "limit": 20, "errors": tempfile.gettempdir(), **changes})


class Peers(unittest.TestCase):
    def test_sizes_double(self):
        for case in work.TITLES:
            nodes = [n * n if isinstance(n, int) else n[0] * n[1] * n[2] for n in work.sizes(case, 4)]
            for few, many in zip(nodes, nodes[1:]):
                self.assertAlmostEqual(many / few, 2, delta=0.03)

    def test_block_is_filled_by_tetrahedra(self):
        points, tets = work.block_mesh((3, 2, 4))
        a, b, c, d = (points[tets[:, n]] for n in range(4))
        volumes = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) / 6
        self.assertTrue((volumes > 0).all())
        self.assertAlmostEqual(volumes.sum(), 24 * work.BLOCK["spacing"] ** 3)
        # neighbors share whole faces: each inner face belongs to two tetrahedra
        faces = np.sort(np.concatenate([tets[:, k] for k in ([0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3])]), axis=1)
        _, uses = np.unique(faces, axis=0, return_counts=True)
        self.assertEqual((uses == 1).sum(), 2 * 2 * (3 * 2 + 2 * 4 + 3 * 4))
        self.assertLessEqual(uses.max(), 2)

    def test_ratios_are_per_node_within_rounds(self):
        rows = [{"peer": "turgor", "nodes": 100, "processor": [1.0, 2.0, 9.0]}, {"peer": "mujoco", "nodes": 200, "processor": [6.0, 12.0, 54.0]}]
        table.add_ratios(rows)
        self.assertEqual(rows[1]["ratio"], 3)  # six times the time of twice the nodes, in every round
        self.assertNotIn("ratio", rows[0])

    def test_a_peer_that_is_missing_or_fails_is_a_row(self):
        row, process = table.start("no_such_peer", "cloth", 8, options())
        self.assertIsNone(process)
        self.assertIn("not installed", table.line({**row, "nodes": ""}))
        # a module of that name whose process ends at once
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "with_json.py").write_text("raise SystemExit('no cloth today')\n")
            old, table.FOLDER = table.FOLDER, pathlib.Path(folder)
            try:
                row, process = table.start("json", "cloth", 8, options())
            finally:
                table.FOLDER = old
        self.assertIsNone(process)
        self.assertIn("no cloth today", table.line(row))

    def test_turgor_answers_rounds(self):
        if not table.version("turgor"):
            self.skipTest("the module turgor is not built")
        for case, size in (("cloth-self", 8), ("block", (4, 4, 3))):
            rows = [pair for pair in [table.start("turgor", case, size, options())] if pair[1]]
            self.assertEqual(len(rows), 1)
            table.run_rounds(rows, 2)
            rows[0][1].end()
            self.assertEqual(len(rows[0][0]["wall"]), 2)
            self.assertGreater(rows[0][0]["fall"], 1e-4)  # [m]: it has moved

    def test_wrong_arguments_end_with_a_sentence(self):
        for words, sentence in ((["--rounds", "0"], "--rounds: expected at least 1, found 0"), (["rope"], "expected cases cloth")):
            ended = subprocess.run([sys.executable, str(FOLDER / "table.py"), *words], capture_output=True, text=True)
            self.assertEqual(ended.returncode, 2)
            self.assertIn(sentence, ended.stderr)


if __name__ == "__main__":
    unittest.main()

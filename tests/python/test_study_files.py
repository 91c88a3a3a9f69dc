"""Files of studies: keys by the content of what a scene names, values of cohort tables, and refused ranges."""
import pathlib
import subprocess
import sys
import unittest

import numpy as np

import turgor
from test_study import STUDY, folder_with, table_of
from turgor.study import run_study
from turgor.study_file import Study


def keys_of(folder):
    return [member["key"] for member in Study(folder / "study.toml").members]


class Contents(unittest.TestCase):
    def study_of(self, files, name, in_table=False):
        """Folder of a study with these files, one of which the scene or the cohort table names as a CT."""
        folder = folder_with()
        for file, content in files.items():
            (folder / file).parent.mkdir(parents=True, exist_ok=True)
            (folder / file).write_bytes(content)
        text = (folder / "study.toml").read_text()
        if in_table:
            (folder / "cases.csv").write_text(f"body.torso.ct\n{name}\n")
            (folder / "study.toml").write_text(text.replace("[vary]", 'cases = "cases.csv"\n[vary]'))
        else:
            (folder / "pad.toml").write_text((folder / "pad.toml").read_text() + f'[body.torso]\nct = "{name}"\n')
        return folder

    # Every key changes when a file changes that the engine reads with the named one, and no key when another file does.
    def test_keys_depend_on_companions(self):
        meta, nrrd = b"NDims = 3\nDimSize = 2 2 2\nElementDataFile = %s\n", b"NRRD0004\ntype: short\nData File: %s\n\n"
        points, tets = b"# points\n4  3  0  0\n", b"1 4 0\n1 1 2 3 4\n"
        dicom = bytes(128) + b"DICM"
        for name, files, companion in (
                ("p.mhd", {"p.mhd": meta % b"p.raw", "p.raw": b"1"}, "p.raw"),
                ("p.mhd", {"p.mhd": meta.replace(b"\n", b"\r\n") % b"data/p one.zraw", "data/p one.zraw": b"1"}, "data/p one.zraw"),
                ("in/p.mhd", {"in/p.mhd": meta % b"p.raw", "in/p.raw": b"1"}, "in/p.raw"),
                ("p.nhdr", {"p.nhdr": nrrd % b"p.raw.gz", "p.raw.gz": b"1"}, "p.raw.gz"),
                ("p.head", {"p.head": nrrd.replace(b"Data File", b"datafile") % b"p.raw", "p.raw": b"1"}, "p.raw"),
                ("p.node", {"p.node": points, "p.ele": tets}, "p.ele"),
                ("p.ele", {"p.ele": tets, "p.node": points}, "p.node"),
                ("patient", {"patient/series/1.dcm": dicom}, "patient/series/1.dcm"),
                ("slices/1", {"slices/1": dicom, "slices/2": dicom + b"1"}, "slices/2")):
            for in_table in (False, True):
                with self.subTest(name, companion=companion, in_table=in_table):
                    folder = self.study_of({**files, "other.raw": b"1"}, name, in_table)
                    before = keys_of(folder)
                    (folder / "other.raw").write_bytes(b"2")
                    self.assertEqual(keys_of(folder), before)
                    (folder / companion).write_bytes(files[companion] + b"2")
                    self.assertFalse(set(keys_of(folder)) & set(before))
                    (folder / companion).write_bytes(files[companion])
                    self.assertEqual(keys_of(folder), before)
                    (folder / companion).unlink()
                    self.assertFalse(set(keys_of(folder)) & set(before))

    # A study that is started again simulates the new samples of a header that has not changed.
    def test_restarted_study_reads_new_samples(self):
        folder = folder_with()
        header = "NDims = 3\nBinaryData = True\nDimSize = 16 12 8\nElementSpacing = 5 5 5\nElementType = MET_SHORT\nElementDataFile = block.raw\n"
        (folder / "block.mhd").write_text(header)
        (folder / "block.toml").write_text('[world]\nduration = 0.1\nframe_rate = 50\ngravity = [0, 0, -9.81]\n'
                                           '[body.block]\nmodel = "lattice"\nct = "block.mhd"\nblock = 1\nfixed = "bone"\n')
        text = STUDY.format(design='{ kind = "grid" }', young="{ values = [0.2] }").replace("pad.toml", "block.toml")
        text = text.replace('"body.pad.young" = { values = [0.2] }', '"body.block.block" = { values = [1, 2] }').replace(
            '"tool.finger.friction" = { values = [0.0, 0.6] }\n', "").replace("tools.finger.force_max_N", "bodies.block.body_nodes")
        (folder / "study.toml").write_text(text)
        for end in (10, 14):
            hu = np.full((8, 12, 16), -1000, np.int16)
            hu[1:-1, 1:-1, 1:end] = 40
            hu[1:-1, 1:-1, 1:3] = 700
            hu.tofile(folder / "block.raw")
            run_study(folder / "study.toml", folder / "out", jobs=2)
            run_study(folder / "study.toml", folder / f"fresh{end}", jobs=2)
            self.assertEqual(table_of(folder / "out"), table_of(folder / f"fresh{end}"))
        self.assertNotEqual(table_of(folder / "fresh10"), table_of(folder / "fresh14"))
        self.assertEqual([row["failed"] for row in table_of(folder / "out")], ["", ""])


class Values(unittest.TestCase):
    # Whole numbers of a table are whole numbers of the scene; a number beyond those of TOML is a real one.
    def test_whole_cells_are_whole_numbers(self):
        folder = folder_with()
        cells = {"7": 7, " +3 ": 3, "-12": -12, "007": 7, "7.0": 7.0, "1e3": 1e3, "99999999999999999999": 1e20, "1_0": 10.0, "x7": "x7"}
        (folder / "cases.csv").write_text("a.b\n" + "".join(f"{cell}\n" for cell in cells))
        text = (folder / "study.toml").read_text().replace("[vary]", 'cases = "cases.csv"\n[vary]')
        (folder / "study.toml").write_text(text.replace("[2e3, 4e3, 8e3]", "[2e3]").replace("[0.0, 0.6]", "[0.0]"))
        found = [member["set"]["a.b"] for member in Study(folder / "study.toml").members]
        self.assertEqual([(type(value), value) for value in found], [(type(value), value) for value in cells.values()])

    # Files that a spreadsheet or an editor began with the byte order mark of UTF-8 have the members of those without it.
    def test_byte_order_mark_is_no_content(self):
        folder = folder_with()
        (folder / "cases.csv").write_text("body.pad.poisson\n0.3\n0.4\n")
        (folder / "study.toml").write_text((folder / "study.toml").read_text().replace("[vary]", 'cases = "cases.csv"\n[vary]'))
        before = keys_of(folder)
        for name in ("cases.csv", "study.toml", "pad.toml"):
            (folder / name).write_bytes(b"\xef\xbb\xbf" + (folder / name).read_bytes())
            self.assertEqual(keys_of(folder), before, name)

    # A cohort varies a key that takes whole numbers only.
    def test_cohort_sets_whole_numbers(self):
        folder = folder_with()
        (folder / "sheet.toml").write_text('[world]\nduration = 0.1\nframe_rate = 50\ngravity = [0, 0, -9.81]\n[body.sheet]\nmodel = "cloth"\n'
                                           'sheet = { corner = [0, 0, 0], side = [0.2, 0, 0], up = [0, 0.2, 0], columns = 6, rows = 6 }\n'
                                           '[body.sheet.hold.edge]\nbox = [[-1, 0.19, -1], [1, 1, 1]]\n')
        (folder / "cases.csv").write_text("body.sheet.solver.sweeps\n3\n 30\n")
        (folder / "study.toml").write_text('[study]\nscene = "sheet.toml"\ncases = "cases.csv"\ndesign = { kind = "grid" }\n'
                                           '[vary]\n[measure]\nsweeps = "bodies.sheet.sweeps"\n')
        report = run_study(folder / "study.toml", folder / "out", jobs=2)
        self.assertEqual(report["failed"], [])
        self.assertEqual([row["sweeps"] for row in table_of(folder / "out")], ["3", "30"])


class Refusals(unittest.TestCase):
    # Ranges without a value, numbers that no design has, and a negative number of processes: status 2 and one line.
    def test_senseless_numbers_get_one_line(self):
        lhs = '{ kind = "lhs", count = 3 }'
        for design, young, arguments, sentence in (
                (lhs, "{ log_uniform = [0, 5] }", [], "vary.body.pad.young: expected log_uniform between ends of one sign and not 0, found [0, 5]"),
                (lhs, "{ log_uniform = [-1, 5] }", [], "vary.body.pad.young: expected log_uniform between ends of one sign and not 0, found [-1, 5]"),
                (lhs, "{ log_uniform = [[1, 2], [3, 0]] }", [], "vary.body.pad.young: expected log_uniform between"),
                (lhs, "{ uniform = [0, inf] }", [], "vary.body.pad.young: expected two numbers"),
                (lhs, "{ uniform = [1, []] }", [], "vary.body.pad.young: expected two numbers"),
                (lhs, "{ uniform = [1, [2]] }", [], "vary.body.pad.young: expected two numbers"),
                (lhs, "{ values = [] }", [], "vary.body.pad.young: expected values = [...] of at least one value, found []"),
                ('{ kind = "grid" }', "{ values = [] }", [], "vary.body.pad.young: expected values = [...] of at least one value, found []"),
                ('{ kind = "grid" }', "{ values = 3 }", [], "vary.body.pad.young: expected values = [...] of at least one value, found 3"),
                ('{ kind = "lhs", count = 0 }', "{ uniform = [1, 2] }", [], "study.design.count: expected a whole number of at least 1, found 0"),
                ('{ kind = "saltelli", count = 1.5 }', "{ uniform = [1, 2] }", [], "study.design.count: expected a whole number of at least 1, found 1.5"),
                ('{ kind = "lhs", count = 3, seed = -1 }', "{ uniform = [1, 2] }", [], "study.design.seed: expected a whole number of at least 0, found -1"),
                (lhs, "{ uniform = [1, 2] }", ["--jobs", "-1"], "--jobs: expected a number of parallel members, or 0 for one per core, found -1")):
            with self.subTest(young=young, design=design):
                folder = folder_with(design, young)
                done = subprocess.run([sys.executable, "-m", "turgor.study", str(folder / "study.toml"), "--out", str(folder / "out"), *arguments],
                                      capture_output=True, text=True)
                self.assertEqual((done.returncode, done.stdout, len(done.stderr.splitlines())), (2, "", 1), done.stderr)
                self.assertIn(sentence, done.stderr)

    # A cell without an end and a folder that cannot be made: status 2 and one line with the name of the file.
    def test_bad_tables_and_folders_are_named(self):
        folder = folder_with()
        text = (folder / "study.toml").read_text()
        (folder / "study.toml").write_text(text.replace("[vary]", 'cases = "cases.csv"\n[vary]'))
        for table, out, name in (('a.b\n"' + 200_000 * "1", "out", "cases.csv: line"), ("a.b\n1\n", "pad.toml", "pad.toml/members"),
                                 ("a.b\n1\n", "/proc/none", "/proc/none")):
            (folder / "cases.csv").write_text(table)
            done = subprocess.run([sys.executable, "-m", "turgor.study", str(folder / "study.toml"), "--out", str(folder / out)],
                                  capture_output=True, text=True)
            self.assertEqual((done.returncode, done.stdout, len(done.stderr.splitlines())), (2, "", 1), done.stderr)
            self.assertIn(name, done.stderr)

    # Values in positions of texts and numbers of a study get a sentence.
    def test_values_of_other_types_are_explained(self):
        folder = folder_with()
        text = (folder / "study.toml").read_text()
        for before, after, sentence in (('scene = "pad.toml"', "scene = 3", "study.scene: expected a text, found 3"),
                                        ("[vary]", "cases = 3\n[vary]", "study.cases: expected a text, found 3"),
                                        ('"tools.finger.force_max_N"', "3", "measure.force: expected a text, found 3"),
                                        ("threads = 1", 'threads = "1"', "run.threads: expected a whole number of at least 0, found '1'"),
                                        ("timeout = 20", "timeout = 0", "run.timeout: expected seconds above 0, found 0")):
            (folder / "study.toml").write_text(text.replace(before, after))
            with self.assertRaisesRegex(turgor.Error, sentence):
                Study(folder / "study.toml")
        (folder / "study.toml").write_text(text[:text.index('"body.pad')].replace("grid", "lhs\", count = 3, x = \"") + "[measure]\n")
        with self.assertRaisesRegex(turgor.Error, "vary: expected a varied key, found none"):
            Study(folder / "study.toml")

    # Ends of one sign are drawn, below 0 too.
    def test_log_uniform_below_zero(self):
        folder = folder_with('{ kind = "lhs", count = 4 }', "{ log_uniform = [-1, -100] }")
        drawn = sorted(member["set"]["body.pad.young"] for member in Study(folder / "study.toml").members)
        for value, low, high in zip(drawn, (-100, -10**1.5, -10, -10**0.5), (-10**1.5, -10, -10**0.5, -1)):
            self.assertTrue(low <= value <= high, drawn)


if __name__ == "__main__":
    unittest.main()

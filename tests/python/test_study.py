"""Studies: designs, members as processes, and recovery after a process was killed."""
import csv
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import numpy as np

import turgor
from scenes import PAD
from turgor.study import run_study
from turgor.study_design import latin_hypercube, saltelli, sobol_indices, varied_value
from turgor.study_file import Study

STUDY = """
[study]
scene = "pad.toml"
design = {design}
[vary]
"body.pad.young" = {young}
"tool.finger.friction" = {{ values = [0.0, 0.6] }}
[measure]
force = "tools.finger.force_max_N"
[run]
threads = 1
timeout = 20
"""


def folder_with(design='{ kind = "grid" }', young="{ values = [2e3, 4e3, 8e3] }"):
    folder = pathlib.Path(tempfile.mkdtemp(prefix="turgor-study-"))
    scene = PAD.replace("path = [[0, 0.03, 0.03, 0.05]]", "path = [[0, 0.03, 0.03, 0.05], [0.1, 0.03, 0.03, 0.034]]")
    (folder / "pad.toml").write_text(scene)
    (folder / "study.toml").write_text(STUDY.format(design=design, young=young))
    return folder


def table_of(out):
    with open(out / "table.csv", newline="") as rows:
        return list(csv.DictReader(rows))


def command_of(pid):
    """Command line of a process; "" if it has ended."""
    try:
        return pathlib.Path(f"/proc/{pid}/cmdline").read_text()
    except OSError:
        return ""


class Designs(unittest.TestCase):
    # A Latin hypercube has one point in every stratum of every parameter.
    def test_latin_hypercube_has_one_point_per_stratum(self):
        points = latin_hypercube(50, 3, seed=4)
        for column in points.T:
            self.assertEqual(sorted((column * 50).astype(int)), list(range(50)))

    # Vector values are interpolated between their ends, linearly or logarithmically.
    def test_vector_values_are_interpolated(self):
        self.assertEqual(varied_value({"uniform": [[20, 10], [80, 40]]}, 0.5), [50, 25])
        self.assertEqual(varied_value({"uniform": [1, 3]}, 0.25), 1.5)
        np.testing.assert_allclose(varied_value({"log_uniform": [[1, 100], [100, 1]]}, 0.5), [10, 10])

    # The Sobol indices of the Ishigami function lie in their confidence intervals.
    def test_sobol_indices_of_ishigami_function(self):
        x = np.pi * (2 * saltelli(4096, 3, seed=2) - 1)
        a, b = 7, 0.1
        f = np.sin(x[:, 0]) + a * np.sin(x[:, 1]) ** 2 + b * x[:, 2] ** 4 * np.sin(x[:, 0])
        variances = (0.5 * (1 + b * np.pi**4 / 5) ** 2, a**2 / 8, 0, b**2 * np.pi**8 * 8 / 225)
        first, total = np.array(variances[:3]) / sum(variances), np.array([variances[0] + variances[3], variances[1], variances[3]]) / sum(variances)
        f[[5, 4096 + 77]] = np.nan  # two members that failed
        found_first, found_total = sobol_indices(f, 3)
        for found, exact in ((found_first, first), (found_total, total)):
            self.assertTrue((np.abs(found[:, 0] - exact) <= found[:, 1] + 1e-3).all(), (found, exact))
            self.assertLess(found[:, 1].max(), 0.06)


class Studies(unittest.TestCase):
    # A study that runs in several processes gives the same table as one process.
    def test_partial_runs_give_whole_study(self):
        folder = folder_with()
        whole = run_study(folder / "study.toml", folder / "whole", jobs=2)
        self.assertIsNone(run_study(folder / "study.toml", folder / "parts", part=(2, 3)))
        self.assertIsNone(run_study(folder / "study.toml", folder / "parts", part=(1, 3)))
        partial = run_study(folder / "study.toml", folder / "parts", part=(3, 3))
        self.assertEqual(table_of(folder / "whole"), table_of(folder / "parts"))
        self.assertEqual(whole["measures"], partial["measures"])
        force = {float(row["body.pad.young"]): float(row["force"]) for row in table_of(folder / "whole")}
        self.assertAlmostEqual(force[4e3] / force[2e3], 2, delta=0.05)  # linear elastic
        alone = turgor.World(folder / "pad.toml", set={"body.pad.young": 8e3, "tool.finger.friction": 0.6})
        for _ in alone.run():
            pass
        self.assertAlmostEqual(alone.report()["tools"][0]["force_max_N"], float(table_of(folder / "whole")[5]["force"]))

    # A member that is rejected and one that times out cost one row each.
    def test_failing_members_cost_one_row_each(self):
        folder = folder_with(young="{ values = [4e3, -1] }")
        text = (folder / "study.toml").read_text().replace("timeout = 20", "timeout = 6").replace(
            '"tool.finger.friction" = { values = [0.0, 0.6] }', '"world.duration" = { values = [0.1, 3590] }')
        (folder / "study.toml").write_text(text)
        (folder / "pad.toml").write_text((folder / "pad.toml").read_text().replace("every = 0.1", "every = 1"))
        report = run_study(folder / "study.toml", folder / "out", jobs=4)
        rows = table_of(folder / "out")
        self.assertEqual([bool(row["force"]) for row in rows], [True, False, False, False])
        self.assertIn("longer than 6 s", rows[1]["failed"])
        self.assertIn("young", rows[2]["failed"])
        self.assertEqual(len(report["failed"]), 3)

    # A killed study resumes without repeating finished members.
    def test_killed_study_resumes(self):
        folder = folder_with(young="{ values = [2e3, 3e3, 4e3, 5e3] }")
        command = [sys.executable, "-m", "turgor.study", str(folder / "study.toml"), "--out", str(folder / "out"), "--jobs", "1"]
        driver = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
        members = folder / "out/members"
        deadline = time.monotonic() + 30
        while time.monotonic() < deadline and len(list(members.glob("*.json"))) < 2:
            time.sleep(0.02)
        os.killpg(driver.pid, signal.SIGKILL)  # together with the member that it waits for
        driver.wait()
        before = {file.name: file.stat().st_mtime_ns for file in members.glob("*.json")}
        self.assertTrue(2 <= len(before) < 8, before)
        again = run_study(folder / "study.toml", folder / "out", jobs=2)
        self.assertEqual(again["failed"], [])
        after = {file.name: file.stat().st_mtime_ns for file in members.glob("*.json")}
        self.assertEqual({name: after[name] for name in before}, before)
        run_study(folder / "study.toml", folder / "whole", jobs=2)
        self.assertEqual(table_of(folder / "out"), table_of(folder / "whole"))

    # Ctrl+C ends a study with its running members, which leave no row, and starts no others. In a terminal all processes get it.
    def test_interrupted_study_ends(self):
        for send in (os.killpg, os.kill):
            with self.subTest(send.__name__):
                folder = folder_with(young="{ values = [4e3] }")
                text = (folder / "study.toml").read_text().replace('"body.pad.young" =', '"world.duration" =').replace("[4e3]", "[0.1, 3590]")
                (folder / "study.toml").write_text(text.replace("[0.0, 0.6]", "[0.0, 0.2, 0.4, 0.6]").replace("timeout = 20", "timeout = 100"))
                (folder / "pad.toml").write_text((folder / "pad.toml").read_text().replace("every = 0.1", "every = 1"))
                command = [sys.executable, "-m", "turgor.study", str(folder / "study.toml"), "--out", str(folder / "out"), "--jobs", "2"]
                # a shell starts commands in the background with SIGINT ignored
                driver = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
                                          preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
                self.addCleanup(driver.kill)
                long_ones = self.long_members_of(driver, 2)
                before = sorted((folder / "out/members").iterdir())
                self.assertEqual(len(before), 4)
                send(driver.pid, signal.SIGINT)
                out, said = driver.communicate(timeout=60)
                self.assertEqual((driver.returncode, out, said), (130, "", "turgor: interrupted; a restarted study continues from the finished members\n"))
                self.assertEqual(sorted((folder / "out/members").iterdir()), before)
                for pid in long_ones:
                    self.assertFalse(pathlib.Path(f"/proc/{pid}").exists())

    def long_members_of(self, driver, count):
        """Process ids of members of 3590 s, once as many run."""
        deadline = time.monotonic() + 120
        while time.monotonic() < deadline:
            children = [pid for threads in pathlib.Path(f"/proc/{driver.pid}/task").glob("*/children") for pid in threads.read_text().split()]
            found = [pid for pid in children if "3590" in command_of(pid)]
            if len(found) == count:
                return found
            time.sleep(0.05)
        self.fail(f"{driver.communicate()} before {count} long members ran")

    # A wrong path in [measure] is refused before the first member, with the name that was probably meant.
    def test_wrong_measure_is_refused_before_members(self):
        for path, sentence in (("tools.finger.force_maxN", "no force_maxN: did you mean force_max_N?"), ("tools.thumb.force_max_N", "no thumb among finger"),
                               ("tool.finger.force_max_N", "no tool: did you mean tools?")):
            folder = folder_with()
            file = folder / "study.toml"
            file.write_text(file.read_text().replace("tools.finger.force_max_N", path))
            with self.assertRaisesRegex(turgor.Error, rf"measure\.force: expected {path}, found {sentence}".replace("?", r"\?")):
                run_study(file, folder / "out", jobs=2)
            self.assertEqual(list((folder / "out/members").iterdir()), [])

    # A study or a scene that does not exist is named.
    def test_missing_files_are_named(self):
        folder = folder_with()
        with self.assertRaisesRegex(turgor.Error, r"^none\.toml: does not exist$"):
            run_study("none.toml", folder / "out")
        (folder / "pad.toml").unlink()
        with self.assertRaisesRegex(turgor.Error, r"study\.toml: .*pad\.toml: does not exist$"):
            run_study(folder / "study.toml", folder / "out")

    # Files of members that no member writes get a sentence with their name, and nothing waits for a pipe.
    def test_foreign_member_files_are_explained(self):
        folder = folder_with(young="{ values = [4e3] }")
        members = folder / "out/members"
        run_study(folder / "study.toml", folder / "out", jobs=2)
        file = sorted(members.glob("*.json"))[0]

        def expect_refusal(sentence):
            with self.assertRaisesRegex(turgor.Error, f"{file.name}: {sentence}"):
                run_study(folder / "study.toml", folder / "out")

        for content in ("[1, 2]", "3", "null", '"text"'):
            file.write_text(content)
            expect_refusal("expected the row of a member, a JSON object, found")
        for content in ("{}", '{"measured": {}}', '{"measured": 3, "failed": "x"}', '{"measured": 3}', '{"measured": {"force": "x"}}'):
            file.write_text(content)
            expect_refusal("expected measured numbers or a failure, found")
        file.unlink()
        file.mkdir()
        expect_refusal("expected a file, found a folder")
        file.rmdir()
        os.mkfifo(file)
        expect_refusal("expected a file, found a pipe")
        file.unlink()
        self.assertEqual(run_study(folder / "study.toml", folder / "out")["failed"], [])

    # Values, folders and pipes in positions of tables and files of a study get a sentence.
    def test_foreign_study_files_are_explained(self):
        folder = folder_with()
        text = (folder / "study.toml").read_text()
        changes = {
            "study: expected a table": "study = 3\n[vary]\n[measure]\n",
            "study.design: expected a table": text.replace('{ kind = "grid" }', "3"),
            "vary.body.pad.young: expected a table": text.replace("{ values = [2e3, 4e3, 8e3] }", "7"),
        }
        for sentence, changed in changes.items():
            (folder / "study.toml").write_text(changed)
            with self.assertRaisesRegex(turgor.Error, sentence):
                run_study(folder / "study.toml", folder / "out")
        (folder / "study.toml").write_text(text.replace("pad.toml", "pipe.toml"))
        os.mkfifo(folder / "pipe.toml")
        with self.assertRaisesRegex(turgor.Error, "pipe.toml: expected a file, found a pipe"):
            run_study(folder / "study.toml", folder / "out")

    # Errors in a study file give an error message.
    def test_study_errors_are_explained(self):
        for design, sentence in (('{ kind = "spiral" }', "grid, lhs, saltelli"), ('{ count = 3 }', "kind")):
            folder = folder_with(design)
            with self.assertRaisesRegex(turgor.Error, sentence):
                run_study(folder / "study.toml", folder / "out")
        for ends in ("[1e3]", "[1e3, [2e3]]", "[[1, 2], [1, 2, 3]]", '["a", 3]', "3"):
            folder = folder_with('{ kind = "lhs", count = 3 }', f"{{ uniform = {ends} }}")
            with self.assertRaisesRegex(turgor.Error, "body.pad.young: expected two numbers, or two vectors"):
                run_study(folder / "study.toml", folder / "out")
        folder = folder_with()
        text = (folder / "study.toml").read_text().replace("force_max_N", "no_such")
        (folder / "study.toml").write_text(text)
        with self.assertRaisesRegex(turgor.Error, "expected tools.finger.no_such, found no no_such among name, body"):
            run_study(folder / "study.toml", folder / "out", jobs=2)
        done = subprocess.run([sys.executable, "-m", "turgor.study", "nowhere.toml"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 2)
        self.assertNotIn("Traceback", done.stderr)

    # A vector parameter is one cell of the table and is passed to the scene.
    def test_vector_is_one_table_cell(self):
        folder = folder_with('{ kind = "lhs", count = 2, seed = 3 }')
        text = (folder / "study.toml").read_text().replace(
            '"tool.finger.friction" = { values = [0.0, 0.6] }', '"world.gravity" = { uniform = [[0, 0, 0], [0, 0, -9.81]] }')
        (folder / "study.toml").write_text(text)
        run_study(folder / "study.toml", folder / "out", jobs=2)
        for row in table_of(folder / "out"):
            gravity = json.loads(row["world.gravity"])
            self.assertEqual(gravity[:2], [0, 0])
            self.assertTrue(-9.81 < gravity[2] < 0)
            self.assertGreater(float(row["force"]), 0.001)

    # Cells that a spreadsheet would run as formulas are texts, and numbers stay numbers.
    def test_table_cells_are_no_formulas(self):
        from turgor.study import _cell
        for text in ("=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "=cmd|' /C calc'!A0"):
            self.assertEqual(_cell(text), '"\'' + text + '"')
        self.assertEqual([_cell(value) for value in (-1.5, 3, 1e-9)], ["-1.5", "3", "1e-09"])
        self.assertEqual(_cell('a "b"'), '"a ""b"""')
        self.assertNotIn("\x1b", _cell("\x1b[2J"))
        folder = folder_with()
        cases = "body.pad.young,tool.finger.force\n=2e3,+x\n"
        (folder / "cases.csv").write_text(cases)
        text = (folder / "study.toml").read_text().replace("[vary]", 'cases = "cases.csv"\n[vary]')
        (folder / "study.toml").write_text(text.replace('"body.pad.young" = { values = [2e3, 4e3, 8e3] }\n', ""))
        run_study(folder / "study.toml", folder / "out", jobs=2)
        for row in table_of(folder / "out"):
            self.assertEqual(row["body.pad.young"], "'=2e3")
            self.assertTrue(row["failed"])
            self.assertFalse(any(cell.startswith(("=", "+", "@")) for cell in row.values()), row)

    # The report contains the Sobol indices of the varied parameters.
    def test_report_has_sobol_indices(self):
        folder = folder_with('{ kind = "saltelli", count = 4, seed = 1 }', "{ uniform = [2e3, 8e3] }")
        report = run_study(folder / "study.toml", folder / "out", jobs=2)
        self.assertEqual(report["members"], 16)
        sobol = report["measures"]["force"]["sobol"]
        self.assertGreater(sobol["body.pad.young"]["total"], sobol["tool.finger.friction"]["total"])
        self.assertEqual(json.loads((folder / "out/report.json").read_text())["measures"], report["measures"])

    def with_cases(self, cases, vary='"tool.finger.friction" = { values = [0.3] }'):
        """Folder of a study of a cohort table, with the folders 001 and 2 of patients."""
        folder = folder_with()
        for patient in ("001", "2"):
            (folder / patient).mkdir()
        (folder / "cases.csv").write_text(cases)
        text = (folder / "study.toml").read_text().replace("[vary]", 'cases = "cases.csv"\n[vary]')
        text = text.replace('"body.pad.young" = { values = [2e3, 4e3, 8e3] }\n', "").replace('"tool.finger.friction" = { values = [0.0, 0.6] }', vary)
        (folder / "study.toml").write_text(text)
        return folder

    # A cell of digits is a folder if the study has one and the scene no number; an empty cell leaves the key to the scene.
    def test_cells_are_numbers_or_files_of_the_study(self):
        folder = self.with_cases("body.torso.ct,body.pad.young,body.pad.fixed\n001,2,\n7,,top\n\n002, 3e3 ,bottom\n")
        cases = [{key: value for key, value in member["set"].items() if key != "tool.finger.friction"} for member in Study(folder / "study.toml").members]
        self.assertEqual(cases, [{"body.torso.ct": "001", "body.pad.young": 2.0}, {"body.torso.ct": 7.0, "body.pad.fixed": "top"},
                                 {"body.torso.ct": 2.0, "body.pad.young": 3e3, "body.pad.fixed": "bottom"}])

    # A row with missing or extra cells is refused with its line.
    def test_rows_of_other_lengths_are_refused(self):
        for row, found in (("2e3", 1), ("2e3,bottom,1", 3)):
            folder = self.with_cases(f"body.pad.young,body.pad.fixed\n4e3,bottom\n{row}\n")
            with self.assertRaisesRegex(turgor.Error, rf"cases\.csv: line 3: expected 2 cells as in the first line, found {found}$"):
                Study(folder / "study.toml")

    # Files of [vary] and of a cohort are relative to the study, in hashes and in runs, from any current folder.
    def test_files_are_relative_to_the_study(self):
        other, before = pathlib.Path(tempfile.mkdtemp(prefix="turgor-other-")), os.getcwd()
        table = "0,0.03,0.03,0.05\n0.1,0.03,0.03,{}\n"
        (other / "press.csv").write_text(table.format(0.04))
        for cases, vary in (("tool.finger.path\npress.csv\n", '"tool.finger.friction" = { values = [0.3] }'),
                            ("tool.finger.friction\n0.3\n", '"tool.finger.path" = { values = ["press.csv"] }')):
            folder = self.with_cases(cases, vary)
            (folder / "press.csv").write_text(table.format(0.034))
            try:
                os.chdir(other)
                press = run_study(folder / "study.toml", folder / "out", jobs=2)["measures"]["force"]
                os.chdir(folder)
                self.assertEqual(run_study("study.toml", "here", jobs=2)["measures"]["force"], press)
                (folder / "press.csv").write_text(table.format(0.035))
                lighter = run_study("study.toml", "here", jobs=2)["measures"]["force"]
            finally:
                os.chdir(before)
            alone = turgor.World(folder / "pad.toml")
            for _ in alone.run():
                pass
            self.assertAlmostEqual(press["max"], alone.report()["tools"][0]["force_max_N"])
            self.assertTrue(0 < lighter["max"] < 0.95 * press["max"])


if __name__ == "__main__":
    unittest.main()

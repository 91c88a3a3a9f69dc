"""The file of a study: its tables, checked, and its members, each with a key that is the hash of all that it depends on.

Files that members name are relative to the study, as in their hashes: members run in its folder.
"""
import csv
import hashlib
import io
import json
import math
import pathlib
import re
import stat
import tomllib

from ._turgor import Error, __version__
from .study_content import content_of
from .study_design import KINDS, rows_of_design

_WHOLE = re.compile(r"\s*[+-]?[0-9]+\s*")


def text_of(file):
    """Text of a file. Raises Error for a folder, a pipe or a device, which could be read without end."""
    check_is_file(file)
    try:
        return pathlib.Path(file).read_text(encoding="utf-8-sig")  # spreadsheets begin a file with the byte order mark
    except UnicodeDecodeError as error:
        raise Error(f"{file}: expected text in UTF-8, found other bytes: {error}") from error


def check_is_file(file):
    mode = pathlib.Path(file).stat().st_mode
    if not stat.S_ISREG(mode):
        kind = "a folder" if stat.S_ISDIR(mode) else "a pipe" if stat.S_ISFIFO(mode) else "a device"
        raise Error(f"{file}: expected a file, found {kind}")


class Study:
    """A validated study file. Raises Error for an invalid one."""

    def __init__(self, file):
        self.file = pathlib.Path(file)
        try:
            text = tomllib.loads(text_of(self.file))
            self._check_tables(text)
            study = text["study"]
            self.scene = self.file.parent / study["scene"]
            self.vary, self.measure, self.run = text["vary"], text["measure"], text.get("run", {})
            self.design = study["design"]
            self._check_run()
            rows = self._designed()
            scene_text = text_of(self.scene)
            scene = tomllib.loads(scene_text)
            cases = self._cases(study.get("cases"), scene)
        except FileNotFoundError as error:
            of_study = "" if str(error.filename) == str(self.file) else f"{self.file}: "
            raise Error(f"{of_study}{error.filename}: does not exist") from error
        except (OSError, tomllib.TOMLDecodeError) as error:
            raise Error(f"{self.file}: {error}") from error
        except KeyError as error:
            raise Error(f"{self.file}: expected a key {error}, found none") from error
        fixed = {"version": __version__, "scene": content_of(scene, self.scene.parent), "text": scene_text,
                 "measure": self.measure}
        self.case_count = len(cases)
        self.members = [{"set": {**case, **row}, "case": number} for number, case in enumerate(cases) for row in rows]
        for member in self.members:
            of = {**fixed, "set": member["set"], "files": content_of(member["set"], self.file.parent)}
            member["key"] = hashlib.sha256(json.dumps(of, sort_keys=True).encode()).hexdigest()[:24]

    def _check_tables(self, text):
        """Checks that the sections, the design and the varied keys are tables, and that names and measures are texts."""
        found = {name: text[name] for name in ("study", "vary", "measure", "run") if name in text}
        if isinstance(text.get("study"), dict) and "design" in text["study"]:
            found["study.design"] = text["study"]["design"]
        if isinstance(text.get("vary"), dict):
            found.update({f"vary.{key}": spec for key, spec in text["vary"].items()})
        for name, value in found.items():
            if not isinstance(value, dict):
                raise Error(f"{self.file}: {name}: expected a table, found {value!r:.60}")
        names = {f"study.{key}": text["study"][key] for key in ("scene", "cases") if key in text.get("study", {})}
        for name, value in {**names, **{f"measure.{key}": path for key, path in text.get("measure", {}).items()}}.items():
            if not isinstance(value, str):
                raise Error(f"{self.file}: {name}: expected a text, found {value!r:.60}")

    def _designed(self):
        kind = self.design["kind"]
        if kind not in KINDS:
            raise Error(f"{self.file}: study.design.kind: expected one of {', '.join(KINDS)}, found {kind}")
        for key, spec in self.vary.items():
            known = [name for name in ("values", "uniform", "log_uniform") if name in spec]
            if len(known) != 1 or (kind == "grid" and known != ["values"]):
                raise Error(f"{self.file}: vary.{key}: expected one of {'values' if kind == 'grid' else 'values, uniform, log_uniform'}, found {spec}")
            self._check_spec(key, known[0], spec[known[0]])
        if kind != "grid":
            self._check_count()
        return rows_of_design(self.design, self.vary)

    def _check_count(self):
        """Checks the numbers of a design that draws its members."""
        if not self.vary:
            raise Error(f"{self.file}: vary: expected a varied key, found none")
        for name, least in (("count", 1), ("seed", 0)):
            number = self.design["count"] if name == "count" else self.design.get("seed", 0)
            if type(number) is not int or number < least:
                raise Error(f"{self.file}: study.design.{name}: expected a whole number of at least {least}, found {number!r:.60}")

    def _check_run(self):
        threads, timeout = self.run.get("threads", 1), self.run.get("timeout", 1)
        if type(threads) is not int or threads < 0:
            raise Error(f"{self.file}: run.threads: expected a whole number of at least 0, found {threads!r:.60}")
        if type(timeout) not in (int, float) or not 0 < timeout < math.inf:
            raise Error(f"{self.file}: run.timeout: expected seconds above 0, found {timeout!r:.60}")

    def _check_spec(self, key, kind, spec):
        """Checks the values of a varied key, or the ends of its range: two numbers, or two vectors of equal size."""
        if kind == "values":
            if not isinstance(spec, list) or not spec:
                raise Error(f"{self.file}: vary.{key}: expected values = [...] of at least one value, found {spec!r:.60}")
            return
        ends = [end if isinstance(end, list) else [end] for end in spec] if isinstance(spec, list) else []
        of_one_kind = len(ends) == 2 and len(ends[0]) == len(ends[1]) and isinstance(spec[0], list) == isinstance(spec[1], list)
        if not of_one_kind or not all(type(n) in (int, float) and math.isfinite(n) for end in ends for n in end):
            raise Error(f"{self.file}: vary.{key}: expected two numbers, or two vectors of as many, found {spec}")
        if kind == "log_uniform" and not all(low * math.copysign(1, high) > 0 and high for low, high in zip(*ends)):
            raise Error(f"{self.file}: vary.{key}: expected log_uniform between ends of one sign and not 0, found {spec}")

    def _cases(self, table, scene):
        """Keys and values of every row; an empty cell leaves the key to the scene."""
        if table is None:
            return [{}]
        file = self.file.parent / table
        rows = csv.reader(io.StringIO(text_of(file), newline=""))
        cases = []
        try:
            keys = next(rows, [])
            for row in rows:
                if row and len(row) != len(keys):
                    raise Error(f"{file}: line {rows.line_num}: expected {len(keys)} cells as in the first line, found {len(row)}")
                if row:
                    cases.append({key: self._value(cell, _named(scene, key)) for key, cell in zip(keys, row) if cell.strip()})
        except csv.Error as error:
            raise Error(f"{file}: line {rows.line_num}: {error}") from error
        return cases

    def _value(self, cell, of_scene):
        """Value of a cell. A text names a file or a folder of the study, also one of digits, unless the scene has a number."""
        is_path = not isinstance(of_scene, (int, float)) and (self.file.parent / cell).exists()
        if is_path:
            return cell
        if _WHOLE.fullmatch(cell) and abs(whole := int(cell)) < 1 << 63:  # of TOML
            return whole
        try:
            return float(cell)
        except ValueError:
            return cell


def _named(scene, key):
    """Value of a scene under a dotted key; None if it has none."""
    for name in key.split("."):
        scene = scene.get(name) if isinstance(scene, dict) else None
    return scene

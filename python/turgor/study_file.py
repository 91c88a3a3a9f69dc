"""The file of a study: its tables, checked, and its members, each with a key that is the hash of all that it depends on.

Files that members name are relative to the study, as in their hashes: members run in its folder.
"""
import csv
import hashlib
import io
import json
import pathlib
import stat
import tomllib

from ._turgor import Error, __version__
from .study_design import KINDS, rows_of_design


def _content(value, folder):
    """Value of a scene for hashing; file names are replaced by hashes of their content."""
    if isinstance(value, dict):
        return {key: _content(one, folder) for key, one in value.items()}
    if isinstance(value, list):
        return [_content(one, folder) for one in value]
    if not isinstance(value, str) or not value:
        return value
    path = folder / value
    if path.is_file():
        return hashlib.sha256(path.read_bytes()).hexdigest()
    if path.is_dir():
        return [[file.name, hashlib.sha256(file.read_bytes()).hexdigest()] for file in sorted(path.iterdir()) if file.is_file()]
    return value


def text_of(file):
    """Text of a file. Raises Error for a folder, a pipe or a device, which could be read without end."""
    check_is_file(file)
    try:
        return pathlib.Path(file).read_text(encoding="utf-8")
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
        fixed = {"version": __version__, "scene": _content(scene, self.scene.parent), "text": scene_text,
                 "measure": self.measure}
        self.case_count = len(cases)
        self.members = [{"set": {**case, **row}, "case": number} for number, case in enumerate(cases) for row in rows]
        for member in self.members:
            of = {**fixed, "set": member["set"], "files": _content(member["set"], self.file.parent)}
            member["key"] = hashlib.sha256(json.dumps(of, sort_keys=True).encode()).hexdigest()[:24]

    def _check_tables(self, text):
        """Checks that the sections, the design and the varied keys are tables."""
        found = {name: text[name] for name in ("study", "vary", "measure", "run") if name in text}
        if isinstance(text.get("study"), dict) and "design" in text["study"]:
            found["study.design"] = text["study"]["design"]
        if isinstance(text.get("vary"), dict):
            found.update({f"vary.{key}": spec for key, spec in text["vary"].items()})
        for name, value in found.items():
            if not isinstance(value, dict):
                raise Error(f"{self.file}: {name}: expected a table, found {value!r:.60}")

    def _designed(self):
        kind = self.design["kind"]
        if kind not in KINDS:
            raise Error(f"{self.file}: study.design.kind: expected one of {', '.join(KINDS)}, found {kind}")
        for key, spec in self.vary.items():
            known = [name for name in ("values", "uniform", "log_uniform") if name in spec]
            if len(known) != 1 or (kind == "grid" and known != ["values"]):
                raise Error(f"{self.file}: vary.{key}: expected one of {'values' if kind == 'grid' else 'values, uniform, log_uniform'}, found {spec}")
            if known != ["values"]:
                self._check_ends(key, spec[known[0]])
        return rows_of_design(self.design, self.vary)

    def _check_ends(self, key, ends):
        """Checks for two numbers, or two vectors of equal size."""
        sizes = [len(end) if isinstance(end, list) else 0 for end in ends] if isinstance(ends, list) else []
        numbers = [n for end in ends for n in (end if isinstance(end, list) else [end])] if sizes else []
        if len(sizes) != 2 or sizes[0] != sizes[1] or not all(type(n) in (int, float) for n in numbers):
            raise Error(f"{self.file}: vary.{key}: expected two numbers, or two vectors of as many, found {ends}")

    def _cases(self, table, scene):
        """Keys and values of every row; an empty cell leaves the key to the scene."""
        if table is None:
            return [{}]
        file = self.file.parent / table
        rows = csv.reader(io.StringIO(text_of(file), newline=""))
        keys, cases = next(rows, []), []
        for row in rows:
            if row and len(row) != len(keys):
                raise Error(f"{file}: line {rows.line_num}: expected {len(keys)} cells as in the first line, found {len(row)}")
            if row:
                cases.append({key: self._value(cell, _named(scene, key)) for key, cell in zip(keys, row) if cell.strip()})
        return cases

    def _value(self, cell, of_scene):
        """Value of a cell. A text names a file or a folder of the study, also one of digits, unless the scene has a number."""
        is_path = not isinstance(of_scene, (int, float)) and (self.file.parent / cell).exists()
        try:
            return cell if is_path else float(cell)
        except ValueError:
            return cell


def _named(scene, key):
    """Value of a scene under a dotted key; None if it has none."""
    for name in key.split("."):
        scene = scene.get(name) if isinstance(scene, dict) else None
    return scene

"""Scenes from Python values: converts dicts and arrays to TOML."""
from __future__ import annotations

import hashlib
import json
import numbers
import os
from collections.abc import Iterable, Mapping, Set

import numpy as np
from numpy.typing import ArrayLike

from ._turgor import Error
from .volume import Volume


class Mesh:
    """A mesh in memory, instead of a file name in a scene or in `set`.

    points: (n, 3) [m]. cells: (m, 3) triangles, counter-clockwise seen from outside, or (m, 4) tetrahedra.
    """

    def __init__(self, points: ArrayLike, cells: ArrayLike) -> None:
        self.points = np.ascontiguousarray(points, dtype=np.float64)
        self.cells = np.ascontiguousarray(cells, dtype=np.int64)
        count = self.points.shape[0]
        if self.points.ndim != 2 or self.points.shape[1] != 3 or not np.isfinite(self.points).all():
            raise Error(f"a mesh: expected points (n, 3) of finite numbers, found an array of {self.points.shape}")
        if self.cells.ndim != 2 or self.cells.shape[1] not in (3, 4) or len(self.cells) == 0:
            raise Error(f"a mesh: expected cells (m, 3) or (m, 4), found an array of {self.cells.shape}")
        if self.cells.min() < 0 or self.cells.max() >= count:
            raise Error(f"a mesh: expected cells of points 0 to {count - 1}, found {self.cells.min()} to {self.cells.max()}")

    def __repr__(self) -> str:
        kind = "triangles" if self.cells.shape[1] == 3 else "tetrahedra"
        return f"Mesh({len(self.points)} points, {len(self.cells)} {kind})"

    def write(self, folder):
        """Writes a legacy VTK file, whose name is the hash of the mesh, and returns its name."""
        is_surface = self.cells.shape[1] == 3
        content = b"".join((repr(self).encode(), self.points.tobytes(), self.cells.tobytes()))
        file = os.path.join(folder, f"{hashlib.sha256(content).hexdigest()[:32]}.vtk")
        rows = np.column_stack([np.full(len(self.cells), self.cells.shape[1]), self.cells])
        kind = "POLYGONS" if is_surface else "CELLS"
        with open(file, "w", encoding="ascii") as out:
            out.write("# vtk DataFile Version 3.0\ngiven\nASCII\n")
            out.write(f"DATASET {'POLYDATA' if is_surface else 'UNSTRUCTURED_GRID'}\nPOINTS {len(self.points)} double\n")
            np.savetxt(out, self.points, fmt="%.17g")
            out.write(f"{kind} {len(rows)} {rows.size}\n")
            np.savetxt(out, rows, fmt="%d")
            if not is_surface:
                out.write(f"CELL_TYPES {len(rows)}\n" + "10\n" * len(rows))
        return file


def _text(value):
    """TOML text of a string."""
    return json.dumps(value, ensure_ascii=False)


class GivenScene:
    """Data of a scene from Python besides its text: files of meshes in `folder`, volumes by body. Without a folder, meshes are refused."""

    def __init__(self, folder):
        self.folder = folder
        self.volumes, self.labels = {}, {}
        self.paths = []

    @property
    def folder_text(self):
        """The folder as it appears in documents and overrides. It lives only until the world is loaded."""
        return _text(self.folder)[1:-1]

    def toml(self, value, key):
        """TOML text of a Python value. Raises Error with the key for a value that TOML does not have."""
        if isinstance(value, np.ndarray):
            value = value.tolist()
        if isinstance(value, (bool, np.bool_)):
            return "true" if value else "false"
        if isinstance(value, numbers.Integral):
            return str(int(value))
        if isinstance(value, numbers.Real):
            return repr(float(value))
        if isinstance(value, (str, os.PathLike)):
            return _text(os.fspath(value))
        if isinstance(value, Mapping):
            items = {f"{k}": v for k, v in value.items() if v is not None}
            return "{ " + ", ".join(f"{_text(k)} = {self.toml(v, f'{key}.{k}')}" for k, v in items.items()) + " }"
        if isinstance(value, Mesh) and self.folder is not None:
            return _text(value.write(self.folder))
        if isinstance(value, (Mesh, Volume)):
            raise Error(f"{key}: expected " + ("a file, found a Mesh" if isinstance(value, Mesh) else
                                               "a Volume as body.NAME.ct or body.NAME.labels, found one elsewhere"))
        if not isinstance(value, Iterable) or isinstance(value, (bytes, bytearray, Set)):
            raise Error(f"{key}: expected a number, a text, a list or a dict, found {type(value).__name__}")
        return "[" + ", ".join(self.toml(v, key) for v in value) + "]"

    def _take_volume(self, key, value):
        """Stores a Volume and returns its text in the scene; None for other values."""
        names = key.split(".")
        if not isinstance(value, Volume):
            return None
        if len(names) != 3 or names[0] != "body" or names[2] not in ("ct", "labels"):
            raise Error(f"{key}: expected a Volume as body.NAME.ct or body.NAME.labels, found one elsewhere")
        if names[2] == "ct":
            self.volumes[names[1]] = value._as_ct()
        else:
            self.labels[names[1]] = value._as_labels()
        return json.dumps(f"given in memory, {key}")

    def document(self, scene):
        """TOML text of a dict of tables."""
        lines = []

        def add(path, table):
            tables = {k: v for k, v in table.items() if isinstance(v, Mapping) and len(path) < 2}
            if path:
                lines.append("[" + ".".join(json.dumps(p) for p in path) + "]")
            for key, value in table.items():
                if key not in tables and value is not None:
                    name = ".".join((*path, key))
                    text = self._take_volume(name, value)
                    lines.append(f"{json.dumps(key)} = {text if text is not None else self.toml(value, name)}")
            for key, value in tables.items():
                add((*path, str(key)), value)

        add((), scene)
        return "\n".join(lines) + "\n"

    def overrides(self, set, volumes, labels):
        """Overrides as key=value texts; None removes a key."""
        values = dict(set or {})
        values.update({f"body.{name}.ct": volume for name, volume in (volumes or {}).items()})
        values.update({f"body.{name}.labels": volume for name, volume in (labels or {}).items()})
        texts = []
        for key, value in values.items():
            text = self._take_volume(key, value)
            texts.append(f"{key}=" + ("" if value is None else text if text is not None else self.toml(value, key)))
        return texts

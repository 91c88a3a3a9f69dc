"""Rules of the glTF 2.0 specification that a validator checks, on a file of the program: chunks, alignment, component types,
bounds of accessors, indices, morph targets and animations. The reader is this file's own."""
import functools
import json
import math
import pathlib
import struct
import subprocess
import tempfile
import unittest

from scenes import PROGRAM, SURFACES

BYTE, UNSIGNED_BYTE, SHORT, UNSIGNED_SHORT, UNSIGNED_INT, FLOAT = 5120, 5121, 5122, 5123, 5125, 5126
LETTER = {BYTE: "b", UNSIGNED_BYTE: "B", SHORT: "h", UNSIGNED_SHORT: "H", UNSIGNED_INT: "I", FLOAT: "f"}
NUMBERS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
VERTICES, INDICES = 34962, 34963  # targets of buffer views


@functools.lru_cache
def parts():
    """JSON and binary chunk of the file of a run."""
    with tempfile.TemporaryDirectory() as scratch:
        scene = pathlib.Path(scratch) / "s.toml"
        scene.write_text(SURFACES)
        subprocess.run([PROGRAM, "run", scene, "-q", "-o", f"{scratch}/out"], check=True)
        data = next(pathlib.Path(scratch, "out").glob("*.glb")).read_bytes()
    magic, version, length = struct.unpack_from("<4sII", data)
    assert (magic, version, length) == (b"glTF", 2, len(data)), "header"
    chunks, at = [], 12
    while at < len(data):
        size, kind = struct.unpack_from("<I4s", data, at)
        assert size % 4 == 0, "chunks are aligned to 4 bytes"
        chunks.append((kind, data[at + 8:at + 8 + size]))
        at += 8 + size
    assert at == len(data) and [kind for kind, _ in chunks] == [b"JSON", b"BIN\0"], "two chunks"
    text, blob = chunks[0][1], chunks[1][1]
    return json.loads(text), blob


def rows_of(index):
    """Rows of an accessor."""
    gltf, blob = parts()
    accessor = gltf["accessors"][index]
    view = gltf["bufferViews"][accessor["bufferView"]]
    letter, width = LETTER[accessor["componentType"]], NUMBERS[accessor["type"]]
    row = width * struct.calcsize(letter)
    step = view.get("byteStride", row)
    begin = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    return [struct.unpack_from(f"<{width}{letter}", blob, begin + n * step) for n in range(accessor["count"])]


def primitives():
    return [primitive for mesh in parts()[0]["meshes"] for primitive in mesh["primitives"]]


class Rules(unittest.TestCase):
    def setUp(self):
        self.gltf, self.blob = parts()

    def test_asset_and_buffer(self):
        self.assertEqual(self.gltf["asset"]["version"], "2.0")
        self.assertEqual(len(self.gltf["buffers"]), 1)
        buffer = self.gltf["buffers"][0]
        self.assertNotIn("uri", buffer)
        self.assertLessEqual(buffer["byteLength"], len(self.blob))
        self.assertLess(len(self.blob) - buffer["byteLength"], 4)

    # Views are in the buffer; accessors are in their views, aligned to their components.
    def test_views_and_accessors(self):
        for view in self.gltf["bufferViews"]:
            self.assertLessEqual(view.get("byteOffset", 0) + view["byteLength"],
                                 self.gltf["buffers"][view["buffer"]]["byteLength"])
            self.assertGreater(view["byteLength"], 0)
            if "byteStride" in view:
                self.assertIn(view["byteStride"], range(4, 253, 4))
        for accessor in self.gltf["accessors"]:
            view = self.gltf["bufferViews"][accessor["bufferView"]]
            size = struct.calcsize(LETTER[accessor["componentType"]])
            row = size * NUMBERS[accessor["type"]]
            step, offset = view.get("byteStride", row), accessor.get("byteOffset", 0)
            self.assertEqual((view.get("byteOffset", 0) + offset) % size, 0)
            self.assertEqual(offset % size, 0)
            self.assertEqual(step % size, 0)
            self.assertGreater(accessor["count"], 0)
            self.assertLessEqual(offset + (accessor["count"] - 1) * step + row, view["byteLength"])
            if view.get("target") == VERTICES:
                self.assertEqual((offset % 4, step % 4), (0, 0))

    # Stated bounds are those of the data, and all numbers are finite.
    def test_bounds(self):
        bounded = 0
        for index, accessor in enumerate(self.gltf["accessors"]):
            rows = rows_of(index)
            self.assertTrue(all(math.isfinite(number) for row in rows for number in row))
            for key, extreme in (("min", min), ("max", max)):
                if key not in accessor:
                    continue
                self.assertEqual(len(accessor[key]), NUMBERS[accessor["type"]])
                for stated, column in zip(accessor[key], zip(*rows)):
                    # the nearest single-precision number of the text is that of the data
                    self.assertEqual(struct.pack("<f", stated), struct.pack("<f", extreme(column)), index)
                bounded += 1
        self.assertGreater(bounded, 0)

    # Positions have bounds; all attributes and targets of a primitive have one row a vertex; indices are in range.
    def test_primitives(self):
        for primitive in primitives():
            self.assertEqual(primitive.get("mode", 4), 4)
            position = self.gltf["accessors"][primitive["attributes"]["POSITION"]]
            count = position["count"]
            for shape in [primitive["attributes"], *primitive.get("targets", [])]:
                for name, index in shape.items():
                    accessor = self.gltf["accessors"][index]
                    self.assertEqual(accessor["count"], count, name)
                    if name in ("POSITION", "NORMAL"):
                        self.assertEqual((accessor["componentType"], accessor["type"]), (FLOAT, "VEC3"))
                    if name == "POSITION":
                        self.assertIn("min", accessor)
                        self.assertIn("max", accessor)
            if "NORMAL" in primitive["attributes"]:
                for row in rows_of(primitive["attributes"]["NORMAL"]):
                    self.assertAlmostEqual(math.hypot(*row), 1, delta=5e-4)
            accessor = self.gltf["accessors"][primitive["indices"]]
            self.assertEqual(accessor["type"], "SCALAR")
            self.assertIn(accessor["componentType"], (UNSIGNED_BYTE, UNSIGNED_SHORT, UNSIGNED_INT))
            self.assertNotIn("byteStride", self.gltf["bufferViews"][accessor["bufferView"]])
            self.assertIn(self.gltf["bufferViews"][accessor["bufferView"]].get("target", INDICES), (INDICES,))
            self.assertEqual(accessor["count"] % 3, 0)
            most = max(row[0] for row in rows_of(primitive["indices"]))
            self.assertLess(most, count)
            self.assertLess(most, {UNSIGNED_BYTE: 0xff, UNSIGNED_SHORT: 0xffff}.get(accessor["componentType"], 0xffffffff),
                            "the largest number restarts a primitive")

    # Primitives of a mesh have as many targets as it has weights.
    def test_targets(self):
        most = 0
        for mesh in self.gltf["meshes"]:
            counts = {len(primitive.get("targets", [])) for primitive in mesh["primitives"]}
            self.assertEqual(len(counts), 1)
            count = counts.pop()
            if "weights" in mesh:
                self.assertEqual(len(mesh["weights"]), count)
            most = max(most, count)
        self.assertGreater(most, 2)

    # Times ascend from 0 and have bounds; a sampler of weights has a row of all targets at each time.
    def test_animations(self):
        for animation in self.gltf["animations"]:
            goals = [(channel["target"]["node"], channel["target"]["path"]) for channel in animation["channels"]]
            self.assertEqual(len(goals), len(set(goals)), "one channel for each property")
            for channel in animation["channels"]:
                sampler = animation["samplers"][channel["sampler"]]
                times = self.gltf["accessors"][sampler["input"]]
                self.assertEqual((times["componentType"], times["type"]), (FLOAT, "SCALAR"))
                self.assertTrue("min" in times and "max" in times)
                rows = [row[0] for row in rows_of(sampler["input"])]
                self.assertGreaterEqual(rows[0], 0)
                self.assertTrue(all(a < b for a, b in zip(rows, rows[1:])))
                values = self.gltf["accessors"][sampler["output"]]["count"]
                self.assertIn(sampler.get("interpolation", "LINEAR"), ("LINEAR", "STEP"))
                targets = 1
                if channel["target"]["path"] == "weights":
                    mesh = self.gltf["meshes"][self.gltf["nodes"][channel["target"]["node"]]["mesh"]]
                    targets = len(mesh["primitives"][0]["targets"])
                self.assertEqual(values, len(rows) * targets, channel["target"])

    # Every index names something, and no node has two parents.
    def test_references(self):
        nodes = self.gltf["nodes"]
        children = [child for node in nodes for child in node.get("children", [])]
        self.assertEqual(len(children), len(set(children)))
        for scene in self.gltf["scenes"]:
            self.assertFalse(set(scene["nodes"]) & set(children), "a scene lists roots")
        self.assertTrue(all(child in range(len(nodes)) for child in children))
        for node in nodes:
            if "mesh" in node:
                self.assertIn(node["mesh"], range(len(self.gltf["meshes"])))
        for primitive in primitives():
            self.assertIn(primitive.get("material", 0), range(len(self.gltf.get("materials", [{}]))))
        for material in self.gltf.get("materials", []):
            color = material.get("pbrMetallicRoughness", {}).get("baseColorFactor", [0, 0, 0, 0])
            self.assertTrue(len(color) == 4 and all(0 <= c <= 1 for c in color))


if __name__ == "__main__":
    unittest.main()

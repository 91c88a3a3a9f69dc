"""Recordings exported to USD and glTF, opened again by other libraries: every point, triangle and time is compared with the
recording."""
import concurrent.futures
import functools
import json
import pathlib
import struct
import subprocess
import sys
import tempfile
import tomllib
import unittest
import unittest.mock

import numpy as np

import turgor
from scenes import CLOTH, PROGRAM, SURFACES
from test_worlds import others_run

try:
    from pxr import Gf, Usd, UsdGeom, UsdShade
except ImportError:
    Usd = None
try:
    import pygltflib
except ImportError:
    pygltflib = None

SCENE = SURFACES.replace("gltf = true", "usd = true\ngltf = true")


@functools.lru_cache
def folder():
    """Results of a run of the scene."""
    scratch = tempfile.TemporaryDirectory()
    scene = pathlib.Path(scratch.name) / "s.toml"
    scene.write_text(SCENE)
    folder.kept = scratch
    subprocess.run([PROGRAM, "run", scene, "-q", "-o", f"{scratch.name}/out"], check=True)
    return pathlib.Path(scratch.name) / "out"


@functools.lru_cache
def moments():
    """All snapshots of the recording."""
    recording = turgor.Recording(folder() / "recording.h5")
    return [recording[i] for i in range(len(recording))]


def expected():
    """By name: points and triangles of every snapshot. Walls of wounds are compared as corners of triangles."""
    surfaces = {}
    for moment in moments():
        for name, body in moment.bodies.items():
            surfaces.setdefault(name, []).append((body.points, body.triangles[:body.wall_begin]))
            surfaces.setdefault(f"{name} wound", []).append((body.points, body.triangles[body.wall_begin:]))
        for name, tool in moment.tools.items():
            surfaces.setdefault(name, []).append((tool.points, tool.triangles))
    return {name: samples for name, samples in surfaces.items() if any(len(t) for _, t in samples)}


class Compared(unittest.TestCase):
    def compare(self, name, found, sample, tolerance):
        """Equal triangles at equal positions; without the walls also equal numbers of vertices."""
        (points, triangles), (x, t) = found, expected()[name][sample]
        if not name.endswith("wound"):
            self.assertEqual(len(points), len(x), name)
            np.testing.assert_allclose(points, x, rtol=0, atol=tolerance, err_msg=f"{name} {sample}")
            np.testing.assert_array_equal(triangles, t, f"{name} {sample}")
        self.assertEqual(len(triangles), len(t))
        if len(t):
            np.testing.assert_allclose(points[triangles], x[t], rtol=0, atol=tolerance, err_msg=f"{name} {sample}")


class Recordings(unittest.TestCase):
    # Snapshots of a recording have the times of the run, and the surfaces of a world in the same state.
    def test_snapshots_equal_world(self):
        times = [moment.time for moment in moments()]
        np.testing.assert_allclose(times, [0, 0.04, 0.08, 0.12, 0.16, 0.2], atol=1e-12)
        self.assertEqual([moment.frame for moment in moments()], [0, 2, 4, 6, 8, 10])
        world = turgor.World(text=SCENE)
        for moment in moments()[:3]:
            world.step(moment.frame - world.frame)
            for name in ("sheet", "torso"):
                np.testing.assert_array_equal(world[name].points, moment.bodies[name].points)
                np.testing.assert_array_equal(world[name].triangles, moment.bodies[name].triangles)
        self.assertGreater(np.linalg.norm(moments()[2].tools["finger"].force), 0)
        recording = turgor.Recording(folder() / "recording.h5")
        self.assertEqual(repr(recording), f"<turgor.Recording {folder() / 'recording.h5'}: 6 snapshots>")
        self.assertEqual(recording.frame_rate, 50)
        self.assertEqual(recording[-1].time, recording[5].time)
        self.assertIn("state_hash", recording.report)
        with self.assertRaises(IndexError):
            recording[6]

    # Other threads run while a recording is opened, read and exported, and threads that read the same one get its snapshots.
    def test_reading_releases_gil(self):
        file = folder() / "recording.h5"
        recording = turgor.Recording(file)
        with tempfile.TemporaryDirectory() as out:
            for call in (lambda: turgor.Recording(file), lambda: recording[1], lambda: turgor.export_gltf(recording, f"{out}/a.glb"),
                         lambda: turgor.export_usd(recording, f"{out}/a.usda")):
                self.assertTrue(others_run(call, times=5))
        with concurrent.futures.ThreadPoolExecutor(4) as pool:
            for index, found in zip([0, 2, 4] * 4, pool.map(lambda n: recording[n], [0, 2, 4] * 4)):
                self.assertEqual(found.time, moments()[index].time)
                for name, body in moments()[index].bodies.items():
                    np.testing.assert_array_equal(found.bodies[name].points, body.points)
        script = (f"import threading, turgor; recording = turgor.Recording({str(file)!r})\n"
                  "reading = threading.Thread(target=lambda: [recording[n] for n in range(6)]); reading.start(); reading.join()")
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
        self.assertEqual((done.stdout, done.stderr), ("", ""))

    # `set` takes the values that World takes: numbers of NumPy, and texts beyond the first plane of Unicode.
    def test_set_takes_values_of_world(self):
        values = {"a.number": np.float32(0.5), "a.whole": np.uint8(3), "a.flag": np.True_, "a.text": "\N{GRINNING FACE}", "a.list": np.arange(2), "a.none": None}
        with unittest.mock.patch("turgor._turgor.open_recording") as opened:
            turgor.Recording("r.h5", set=values)
        texts = dict(text.split("=", 1) for text in opened.call_args.args[1])
        self.assertEqual(texts.pop("a.none"), "")
        found = {key: tomllib.loads(f"value = {text}")["value"] for key, text in texts.items()}
        self.assertEqual(found, {"a.number": 0.5, "a.whole": 3, "a.flag": True, "a.text": "\N{GRINNING FACE}", "a.list": [0, 1]})
        for value in (turgor.Volume(np.zeros((2, 2, 2)), (1, 1, 1)), turgor.Mesh(np.eye(3), [[0, 1, 2]])):
            with self.assertRaisesRegex(turgor.Error, "file"):
                turgor.Recording("r.h5", set={"body.torso.ct": value})

    # Other files, endings and folders are refused with a message, and nothing is written.
    def test_wrong_input_is_refused(self):
        with self.assertRaisesRegex(turgor.Error, "no-such.h5"):
            turgor.Recording("no-such.h5")
        with self.assertRaisesRegex(turgor.Error, "expected a name that ends in .usda"):
            turgor.export_usd(folder() / "recording.h5", "a.fbx")
        with self.assertRaisesRegex(turgor.Error, "expected a name that ends in .glb"):
            turgor.export_gltf(folder() / "recording.h5", "a.gltf")
        with self.assertRaisesRegex(turgor.Error, "no-such-folder"):
            turgor.export_gltf(folder() / "recording.h5", folder() / "no-such-folder/a.glb")
        script = ("import sys; sys.modules['pxr'] = None; import turgor\n"
                  f"try: turgor.export_usd({str(folder() / 'recording.h5')!r}, 'a.usdc')\nexcept turgor.Error as error: print(error)")
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
        self.assertIn("a.usdc: expected usd-core, found none; pip install usd-core", done.stdout, done.stderr)

    # The program writes the files of the module, byte by byte; too many snapshots for glTF are refused at once.
    def test_program_writes_files_of_module(self):
        with tempfile.TemporaryDirectory() as scratch:
            done = subprocess.run([sys.executable, "-m", "turgor.export", folder() / "recording.h5", f"{scratch}/a.usda", f"{scratch}/a.glb"],
                                  capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("a.glb: 6 snapshots", done.stdout)
            for mine, programs in (("a.usda", "surfaces.usda"), ("a.glb", "surfaces.glb")):
                self.assertEqual(pathlib.Path(scratch, mine).read_bytes(), (folder() / programs).read_bytes(), mine)
        self.assertIn("surfaces.glb", json.loads((folder() / "report.json").read_text())["files"])
        # a snapshot every third frame, at 50 frames a second
        with self.assertRaisesRegex(turgor.Error, "expected at most 1000 snapshots for glTF, found 1001"):
            turgor.World(text=CLOTH, set={"output.gltf": True, "output.snapshots.every": 0.05, "world.duration": 60})


@unittest.skipUnless(Usd, "usd-core is not installed")
class ToUsd(Compared):
    def check(self, file):
        stage = Usd.Stage.Open(str(file))
        self.assertEqual(UsdGeom.GetStageMetersPerUnit(stage), 1)
        self.assertEqual(UsdGeom.GetStageUpAxis(stage), UsdGeom.Tokens.z)
        self.assertEqual((stage.GetTimeCodesPerSecond(), stage.GetStartTimeCode(), stage.GetEndTimeCode()), (50, 0, 10))
        self.assertEqual(stage.GetDefaultPrim().GetName(), "Turgor")
        meshes = {prim.GetDisplayName(): UsdGeom.Mesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.Mesh)}
        self.assertEqual(set(meshes), set(expected()))
        self.assertEqual({"pad", "sheet", "torso", "torso wound", "finger"}, set(meshes))
        for name, mesh in meshes.items():
            self.assertEqual(mesh.GetPointsAttr().GetTimeSamples(), [0, 2, 4, 6, 8, 10])
            for sample, moment in enumerate(moments()):
                points = np.array(mesh.GetPointsAttr().Get(moment.frame)).reshape(-1, 3)
                counts = np.array(mesh.GetFaceVertexCountsAttr().Get(moment.frame))
                self.assertTrue((counts == 3).all())
                corners = np.array(mesh.GetFaceVertexIndicesAttr().Get(moment.frame), dtype=int).reshape(-1, 3)
                self.assertEqual(len(corners), len(counts))
                self.compare(name, (points, corners), sample, 0)
                if len(points):
                    box = np.array(mesh.GetExtentAttr().Get(moment.frame))
                    np.testing.assert_array_equal(box, [points.min(0), points.max(0)])
                    self.assertEqual(mesh.GetNormalsInterpolation(), "vertex")
                    self.assertTrue(UsdGeom.Mesh.ValidateTopology(mesh.GetFaceVertexIndicesAttr().Get(moment.frame),
                                                                  mesh.GetFaceVertexCountsAttr().Get(moment.frame), len(points))[0])
            material = UsdShade.MaterialBindingAPI(mesh).ComputeBoundMaterial()[0]
            shader = material.ComputeSurfaceSource()[0]
            self.assertEqual(shader.GetIdAttr().Get(), "UsdPreviewSurface")
            color = shader.GetInput("diffuseColor").Get()
            self.assertEqual(mesh.GetDisplayColorAttr().Get()[0], Gf.Vec3f(color))
        self.assertTrue(meshes["sheet"].GetDoubleSidedAttr().Get())
        self.assertGreater(len(meshes["torso"].GetFaceVertexIndicesAttr().GetTimeSamples()), 1)
        self.assertEqual(len(meshes["sheet"].GetFaceVertexIndicesAttr().GetTimeSamples()), 1)

    # usd-core finds all points, triangles, times, materials, units and axes, in the text of the program.
    def test_usd_has_all_points(self):
        self.check(folder() / "surfaces.usda")

    # The binary form has the same content.
    def test_binary_usd_has_all_points(self):
        with tempfile.TemporaryDirectory() as scratch:
            turgor.export_usd(folder() / "recording.h5", f"{scratch}/a.usdc")
            self.assertEqual(pathlib.Path(f"{scratch}/a.usdc").read_bytes()[:8], b"PXR-USDC")
            self.check(f"{scratch}/a.usdc")
            turgor.export_usd(folder() / "recording.h5", f"{scratch}/a.usdz")
            self.check(f"{scratch}/a.usdz")


@unittest.skipUnless(pygltflib, "pygltflib is not installed")
class ToGltf(Compared):
    def numbers(self, index):
        """Values of an accessor, whose limits are checked."""
        accessor = self.gltf.accessors[index]
        view = self.gltf.bufferViews[accessor.bufferView]
        columns = {"SCALAR": 1, "VEC3": 3}[accessor.type]
        kind = {5126: "<f4", 5125: "<u4"}[accessor.componentType]
        self.assertEqual(view.byteOffset % 4, 0)
        self.assertEqual(view.byteLength, 4 * columns * accessor.count)
        values = np.frombuffer(self.blob, kind, columns * accessor.count, view.byteOffset).reshape(-1, columns)
        if accessor.min:  # an empty list if there are none
            np.testing.assert_array_equal(values.min(0), np.array(accessor.min, kind))
            np.testing.assert_array_equal(values.max(0), np.array(accessor.max, kind))
        return values

    def animated(self, node, path, time):
        """Value of an animated property at a time: linear or in steps, constant beyond the ends."""
        for channel in self.gltf.animations[0].channels:
            if (channel.target.node, channel.target.path) != (node, path):
                continue
            sampler = self.gltf.animations[0].samplers[channel.sampler]
            times = self.numbers(sampler.input).ravel()
            self.assertTrue((np.diff(times) > 0).all())
            values = self.numbers(sampler.output).reshape(len(times), -1)
            time = np.float32(time)
            if sampler.interpolation == "STEP":
                return values[max(np.searchsorted(times, time, side="right") - 1, 0)]
            return np.array([np.interp(time, times, column) for column in values.T])
        return None

    # pygltflib finds one shape of every surface at every time, with the points of the recording.
    def test_gltf_has_all_points(self):
        self.gltf = pygltflib.GLTF2().load(str(folder() / "surfaces.glb"))
        self.blob = self.gltf.binary_blob()
        self.assertEqual(self.gltf.asset.version, "2.0")
        root = self.gltf.nodes[self.gltf.scenes[0].nodes[0]]
        np.testing.assert_allclose(root.rotation, [-np.sqrt(0.5), 0, 0, np.sqrt(0.5)], atol=1e-12)  # z up to y up
        for sample, moment in enumerate(moments()):
            seen = set()
            for index in root.children:
                node = self.gltf.nodes[index]
                mesh = self.gltf.meshes[node.mesh]
                primitive = mesh.primitives[0]
                scale = self.animated(index, "scale", moment.time)
                if scale is not None and not scale.any():
                    continue
                name = self.gltf.materials[primitive.material].name
                self.assertNotIn(name, seen)
                seen.add(name)
                points = self.numbers(primitive.attributes.POSITION).astype(float)
                normals = self.numbers(primitive.attributes.NORMAL).astype(float)
                weights = self.animated(index, "weights", moment.time)
                targets = primitive.targets or []
                self.assertEqual(len(targets), 0 if weights is None else len(weights))
                for weight, target in zip(weights if weights is not None else [], targets):
                    points = points + weight * self.numbers(target["POSITION"])
                    normals = normals + weight * self.numbers(target["NORMAL"])
                np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-3)
                self.compare(name, (points, self.numbers(primitive.indices).reshape(-1, 3).astype(int)), sample, 2e-7)
            self.assertEqual(seen, {name for name, samples in expected().items() if len(samples[sample][1])})


if __name__ == "__main__":
    unittest.main()

"""The OpenIGTLink server with programs that connect over the loopback interface. Received bytes are decoded by the protocol's
document, not by the module under test."""
import pathlib
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import turgor
from scenes import PAD, TORSO
from turgor import openigtlink
from turgor.live import LiveWorld, axes_of, quaternion_of

HEADER = struct.Struct(">H12s20sIIQQ")  # version, type, name, time, fraction, size, CRC [OpenIGTLink protocol 2]
RAS = np.array([-1, -1, 1])
HEADERS = pathlib.Path("/usr/include/openigtlink")  # of Debian's libopenigtlink-dev


def crc64(data):
    """CRC-64 of ECMA-182, bit by bit."""
    crc = 0
    for byte in data:
        crc ^= byte << 56
        for _ in range(8):
            crc = ((crc << 1) ^ 0x42F0E1EBA9EA3693 if crc >> 63 else crc << 1) & 0xFFFFFFFFFFFFFFFF
    return crc


def transform(name, matrix):
    """Bytes of a TRANSFORM: three columns and the position [mm]."""
    body = struct.pack(">12f", *np.asarray(matrix)[:3].T.ravel())
    return HEADER.pack(1, b"TRANSFORM", name.encode(), 0, 0, len(body), crc64(body)) + body


class Program:
    """Another program: connects, and keeps the newest message of every name."""

    def __init__(self, port):
        self.link = socket.create_connection(("127.0.0.1", port), timeout=10)
        self.file = self.link.makefile("rb")

    def read(self):
        """Type, name, body of the next message."""
        _, kind, name, _, _, size, crc = HEADER.unpack(self.file.read(HEADER.size))
        body = self.file.read(size)
        if size < 2000:  # bit by bit is slow
            assert crc64(body) == crc
        return kind.rstrip(b"\0").decode(), name.rstrip(b"\0").decode(), body

    def read_until(self, kind, name, accepts=lambda body: True):
        for _ in range(2000):
            found = self.read()
            if found[:2] == (kind, name) and accepts(found[2]):
                return found[2]
        raise AssertionError(f"no such {kind} of {name}")

    def close(self):
        self.file.close()
        self.link.close()


def matrix_in(body):
    matrix = np.eye(4)
    matrix[:3] = np.array(struct.unpack(">12f", body)).reshape(4, 3).T
    return matrix


def surface_in(body):
    """Points [mm] and triangles of a POLYDATA."""
    points, _, vertex_bytes, _, line_bytes, polygons, polygon_bytes, _, strip_bytes, attributes = struct.unpack(">10I", body[:40])
    assert (vertex_bytes, line_bytes, strip_bytes, attributes) == (0, 0, 0, 0)
    assert len(body) == 40 + 12 * points + polygon_bytes
    rows = np.frombuffer(body, ">u4", offset=40 + 12 * points).reshape(polygons, 4)
    assert (rows[:, 0] == 3).all()
    return np.frombuffer(body, ">f4", 3 * points, 40).reshape(-1, 3), rows[:, 1:]


@unittest.skipUnless(openigtlink.pyigtl, "pyigtl is not installed")
class OpenIGTLink(unittest.TestCase):
    def bridge(self, text, *arguments, **options):
        bridge = openigtlink.Bridge(turgor.World(text=text, keeps_forces=False), *arguments, port=0, **options)
        self.addCleanup(bridge.close)
        return bridge

    def program(self, bridge):
        program = Program(bridge.port)
        self.addCleanup(program.close)
        return program

    def started(self, bridge, seconds=30):
        thread = threading.Thread(target=bridge.run, args=(seconds,))
        thread.start()
        self.addCleanup(thread.join)
        self.addCleanup(bridge.close)  # before the join
        return thread

    # A received transform leads the tool into the body; the sent surface and tool are those of the world, in mm and RAS.
    def test_tracked_tool_presses_body(self):
        bridge = self.bridge(PAD, tracked="Stylus")
        program = self.program(bridge)
        rest = bridge.live.world["pad"].points
        thread = self.started(bridge)
        points, triangles = surface_in(program.read_until("POLYDATA", "pad"))
        np.testing.assert_allclose(points, 1e3 * RAS * rest, atol=1e-2)
        np.testing.assert_array_equal(triangles, bridge.live.world["pad"].triangles)

        goal = np.array([0.03, 0.03, 0.033])  # 3 mm deep
        turned = axes_of(np.array([np.cos(0.2), 0, 0, np.sin(0.2)]))
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = RAS[:, None] * turned, 1e3 * RAS * goal
        program.link.sendall(transform("Other", np.eye(4)) + transform("Stylus", matrix))
        reached = lambda body: np.allclose(matrix_in(body), matrix, atol=1e-3)
        program.read_until("TRANSFORM", "finger", reached)
        pressed = lambda body: np.abs(surface_in(body)[0] - 1e3 * RAS * rest).max() > 2
        program.read_until("POLYDATA", "pad", pressed)
        bridge.live.stops = True
        thread.join()
        self.assertGreater(bridge.live.wrench[0, 2], 0.05)
        self.assertEqual(bridge.live.refused, 0)

        # the same pose in a world of its own gives the same force
        alone = turgor.World(text=PAD)
        poses = np.repeat([[[*goal, np.cos(0.2), 0, 0, np.sin(0.2)]]], 100, axis=0)
        poses[:60, 0, 2] = np.linspace(0.05, goal[2], 60)
        np.testing.assert_allclose(bridge.live.wrench[0, 2], alone.tick(poses)[-1, 0, 2], rtol=0.02)

    # A program of the OpenIGTLink library reads the same surface and tool, and leads the tool.
    @unittest.skipUnless(HEADERS.is_dir() and shutil.which("c++"), "libopenigtlink-dev or a compiler is not installed")
    def test_program_of_library_leads_tool(self):
        client = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory())) / "client"
        subprocess.run(["c++", "-std=c++20", f"-I{HEADERS}", pathlib.Path(__file__).with_name("igtl_client.cpp"), "-lOpenIGTLink", "-lpthread",
                        "-o", client], check=True)
        bridge = self.bridge(PAD, tracked="Stylus")
        pad = bridge.live.world["pad"]
        self.started(bridge)
        goal = [-30.0, -30.0, 45.0]  # [mm, RAS], above the pad
        done = subprocess.run([client, str(bridge.port), "pad", "finger", "Stylus", *map(str, goal)], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        surface, tool = (line.split() for line in done.stdout.splitlines())
        self.assertEqual(surface[:3], ["surface", str(len(pad.points)), str(len(pad.triangles))])
        ends = 1e3 * RAS * pad.points[[0, -1]]
        np.testing.assert_allclose(np.array(surface[3:], dtype=float).reshape(2, 3), ends, atol=1e-2)
        np.testing.assert_allclose(np.array(tool[1:], dtype=float), goal, atol=1e-2)

    # The deformed CT arrives as IMAGE with the samples and the geometry of the volume.
    def test_deformed_ct_arrives(self):
        scene = TORSO + "[tool.finger]\nbody = \"torso\"\nshape = { sphere = 0.01 }\npath = [[0, 0, -0.3, 0]]\n"
        bridge = self.bridge(scene, image="torso")
        program = self.program(bridge)
        while not bridge.connections:
            time.sleep(0.001)
        bridge.send_state()
        body = program.read_until("IMAGE", "torso CT")
        version, components, scalar, endian, axes, *size = struct.unpack(">HBBBBHHH", body[:12])
        self.assertEqual((version, components, scalar, endian, axes), (1, 1, 4, 2, 1))  # int16, little, RAS
        volume = bridge.live.world["torso"].deformed_volume()
        self.assertEqual(size, list(volume.samples.shape[::-1]))
        np.testing.assert_array_equal(np.frombuffer(body, "<i2", offset=72), volume.samples.ravel())
        columns = np.array(struct.unpack(">12f", body[12:60])).reshape(4, 3)  # axes with spacing, center [mm]
        middle = volume.affine @ [*(np.array(size) - 1) / 2, 1]
        np.testing.assert_allclose(columns[:3], 1e3 * (RAS[:, None] * volume.affine[:3, :3]).T, rtol=1e-6, atol=1e-6)
        np.testing.assert_allclose(columns[3], 1e3 * RAS * middle[:3], rtol=1e-5, atol=1e-3)

    # Damaged, huge and foreign messages lead no tool; a program that leaves does not disturb the others.
    def test_bad_messages_lead_nothing(self):
        bridge = self.bridge(PAD)
        good, bad, huge = (self.program(bridge) for _ in range(3))
        self.started(bridge)
        damaged = bytearray(transform("finger", np.eye(4)))
        damaged[-1] ^= 1
        sheared = np.eye(4)
        sheared[0, 1] = 0.5
        not_finite = np.eye(4)
        not_finite[0, 3] = np.nan
        bad.link.sendall(bytes(damaged) + transform("finger", sheared) + transform("finger", not_finite))
        huge.link.sendall(HEADER.pack(1, b"TRANSFORM", b"finger", 0, 0, 1 << 40, 0))
        while bridge.live.refused < 2:
            time.sleep(0.001)
        with self.assertRaises((OSError, struct.error)):  # its connection was closed
            while True:
                huge.read()
        bad.close()
        good.read_until("TRANSFORM", "finger")
        self.assertIsNone(bridge.live.goal)
        self.assertEqual(bridge.live.refused, 2)

    # Wrong names and occupied ports are refused with a message.
    def test_wrong_input_is_refused(self):
        bridge = self.bridge(PAD)
        with self.assertRaisesRegex(turgor.Error, "expected a tool of the scene .finger., found hook"):
            self.bridge(PAD, "hook")
        with self.assertRaisesRegex(turgor.Error, "expected a body with model = .lattice."):
            self.bridge(PAD, image="pad")
        with self.assertRaisesRegex(turgor.Error, f"127.0.0.1:{bridge.port}: Address already in use"):
            openigtlink.Bridge(turgor.World(text=PAD), port=bridge.port)
        with self.assertRaisesRegex(turgor.Error, "127.0.0.1:70000: .*0-65535"):
            openigtlink.Bridge(turgor.World(text=PAD), port=70000)

    # The program of the page runs a scene and prints its counts.
    def test_program_runs_scene(self):
        scene = pathlib.Path(self.enterContext(__import__("tempfile").TemporaryDirectory())) / "pad.toml"
        scene.write_text(PAD)
        done = subprocess.run([sys.executable, "-m", "turgor.openigtlink", scene, "--port", "0", "--seconds", "0.2"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("finger leads finger", done.stdout)
        self.assertIn("200 ticks", done.stdout)


class Live(unittest.TestCase):
    # A quaternion and its matrix agree for rotations about all axes, up to the sign.
    def test_quaternions_agree_with_matrices(self):
        random = np.random.default_rng(5)
        for _ in range(200):
            q = random.normal(size=4) * random.integers(0, 2, 4) + [1e-3, 0, 0, 0]
            q /= np.linalg.norm(q)
            found = quaternion_of(axes_of(q))
            self.assertAlmostEqual(abs(found @ q), 1, places=12)
        self.assertIsNone(quaternion_of(np.diag([1, 1, -1])))
        self.assertIsNone(quaternion_of(2 * np.eye(3)))

    # The led tool moves to its goal on a line at the largest speed, and stays there.
    def test_led_tool_is_not_faster_than_limit(self):
        live = LiveWorld(turgor.World(text=PAD), fastest=0.25)
        start = live.poses[0, :3].copy()
        goal = start + [0.003, 0, 0.004]
        live.lead(goal, [2, 0, 0, 0])
        positions = []
        for count in (1, 7, 2, 30):
            live.tick(count)
            positions.append(live.poses[0, :3].copy())
        travel = [np.linalg.norm(p - start) for p in positions]
        np.testing.assert_allclose(travel, [0.25e-3, 2e-3, 2.5e-3, 5e-3], atol=1e-12)
        np.testing.assert_allclose(positions[-1], goal, atol=1e-12)
        np.testing.assert_allclose(live.poses[0, 3:], [1, 0, 0, 0])


if __name__ == "__main__":
    unittest.main()

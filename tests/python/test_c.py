"""The C interface from a language that reads no headers: ctypes. TURGOR_C is libturgor_c, from scripts/python."""
import ctypes
import os
import unittest

import turgor
from scenes import PAD


class WorldDef(ctypes.Structure):
    _fields_ = [("size", ctypes.c_size_t), ("scene", ctypes.c_char_p), ("text", ctypes.c_char_p)]  # the rest is as by default


class Command(ctypes.Structure):
    _fields_ = [("position", ctypes.c_double * 3), ("orientation", ctypes.c_double * 4), ("hold", ctypes.c_int32),
                ("reserved", ctypes.c_int32)]


class Reading(ctypes.Structure):
    _fields_ = [("force", ctypes.c_double * 3), ("torque", ctypes.c_double * 3)]


@unittest.skipUnless("TURGOR_C" in os.environ, "TURGOR_C names no library")
class CInterface(unittest.TestCase):
    # The C interface gives the same forces as the Python module, and errors as text.
    def test_ctypes_matches_python(self):
        c = ctypes.CDLL(os.environ["TURGOR_C"])
        c.tg_error.restype = ctypes.c_char_p
        world = ctypes.c_void_p()
        definition = WorldDef(ctypes.sizeof(WorldDef), None, PAD.encode())
        self.assertEqual(c.tg_world_create(ctypes.byref(definition), ctypes.byref(world)), 0, c.tg_error())
        commands, readings = (Command * 60)(), (Reading * 60)()
        poses = [[[0.03, 0.03, 0.036 - 4e-5 * n, 1, 0, 0, 0]] for n in range(60)]
        for command, (pose,) in zip(commands, poses):
            command.position[:], command.orientation[:] = pose[:3], pose[3:]
        status = c.tg_world_tick(world, commands, ctypes.c_size_t(ctypes.sizeof(Command)), readings,
                                 ctypes.c_size_t(ctypes.sizeof(Reading)), ctypes.c_size_t(60))
        self.assertEqual(status, 0, c.tg_error())
        forces = turgor.World(text=PAD).tick(poses)
        self.assertEqual([list(r.force) + list(r.torque) for r in readings], forces[:, 0].tolist())
        self.assertGreater(forces[-1, 0, 2], 0.01)
        definition.text = b"[world]\nduration = -1\n"
        other = ctypes.c_void_p()
        self.assertEqual(c.tg_world_create(ctypes.byref(definition), ctypes.byref(other)), 1)
        self.assertIn(b"duration", c.tg_error())
        self.assertEqual(c.tg_world_destroy(world), 0)


if __name__ == "__main__":
    unittest.main()

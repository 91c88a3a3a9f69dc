"""A world in 3D Slicer and other programs of OpenIGTLink, live:

    python -m turgor.openigtlink scenes/palpation.toml --tool finger --tracked StylusToReference

Sends the surface of every body (POLYDATA), the pose of every tool (TRANSFORM) and, if asked, the deformed CT of a lattice
(IMAGE), and takes the pose of a tracked tool (TRANSFORM). Names of messages are the names of bodies and tools. Units and axes
are those of 3D Slicer: millimeters, RAS. Needs pyigtl: pip install turgor[openigtlink].
"""
import argparse
import contextlib
import socket
import sys
import threading
import time

import numpy as np

from ._turgor import Error
from .live import LiveWorld, axes_of, overrides, quaternion_of
from .world import World

try:
    import pyigtl
    from pyigtl.messages import CRC64
except ImportError:
    pyigtl = None

PORT = 18944  # of OpenIGTLink
MOST_BYTES = 1 << 20  # of a received message; longer ones end the connection
TO_RAS = np.array([-1.0, -1.0, 1.0])


def _frame_to_ras(axes, position):
    """(4, 4) matrix [mm, RAS] of axes (columns, LPS) and a position [m, LPS]."""
    matrix = np.eye(4)
    matrix[:3, :3] = TO_RAS[:, None] * axes
    matrix[:3, 3] = 1e3 * TO_RAS * position
    return matrix


def surface_message(body):
    """POLYDATA of the present surface of a body."""
    polygons = np.column_stack([np.full(len(body.triangles), 3), body.triangles]).astype(np.uint32)
    return pyigtl.PolyDataMessage(points=(1e3 * TO_RAS * body.points).astype(np.float32), polygons=polygons.ravel(), device_name=body.name)


def tool_message(name, pose):
    """TRANSFORM of a tool from its position [m] and quaternion w, x, y, z."""
    return pyigtl.TransformMessage(_frame_to_ras(axes_of(pose[3:]), pose[:3]), device_name=name)


def image_message(name, volume):
    """IMAGE of a Volume."""
    matrix = np.diag([*TO_RAS, 1]) @ volume.affine
    matrix[:3] *= 1e3
    return pyigtl.ImageMessage(volume.samples, matrix, "ras", device_name=name)


class Connection:
    """A connection with another program. `send` replaces an older message of its type and name that was not sent yet."""

    def __init__(self, link, on_transform):
        self.link, self.on_transform = link, on_transform
        self.waiting, self.changed = {}, threading.Condition()
        self.is_open = True
        self.threads = [threading.Thread(target=loop, daemon=True) for loop in (self._send, self._receive)]
        for thread in self.threads:
            thread.start()

    def send(self, message):
        with self.changed:
            self.waiting[type(message), message.device_name] = message
            self.changed.notify()

    def close(self):
        with self.changed:
            self.is_open = False
            self.changed.notify()
        with contextlib.suppress(OSError):
            self.link.shutdown(socket.SHUT_RDWR)
        self.link.close()

    def _send(self):
        while True:
            with self.changed:
                self.changed.wait_for(lambda: self.waiting or not self.is_open)
                messages, self.waiting = list(self.waiting.values()), {}
            if not self.is_open:
                return
            try:
                for message in messages:
                    self.link.sendall(message.pack())
            except OSError:
                return self.close()

    def _read(self, size):
        """Exactly this number of bytes; None at the end of the connection."""
        data = b""
        while len(data) < size:
            piece = self.link.recv(size - len(data))
            if not piece:
                return None
            data += piece
        return data

    def _receive(self):
        with contextlib.suppress(OSError, ValueError):  # ValueError: a header that is not text
            while self.is_open:
                header = self._read(pyigtl.MessageBase.IGTL_HEADER_SIZE)
                fields = header and pyigtl.MessageBase.parse_header(header)
                if not fields or fields["body_size"] > MOST_BYTES:
                    break
                body = self._read(fields["body_size"])
                if body is None:
                    break
                intact = CRC64(body) == int.from_bytes(header[-8:], "big")
                if fields["message_type"] == "TRANSFORM" and intact and len(body) >= 48:
                    message = pyigtl.TransformMessage()
                    with contextlib.suppress(Exception):  # a body that is too long, or damaged metadata
                        message.unpack(fields, body)
                        self.on_transform(message.device_name, message.matrix)
        self.close()


class Bridge:
    """A server of OpenIGTLink for a world. Its programs connect and disconnect at any time.

    tool: the tool that is tracked, default the first. tracked: name of the received TRANSFORM; default: the tool's name.
    image: a lattice body whose deformed CT is sent every `image_every` seconds. Frames wait while it is computed.
    host: other machines can connect only if this is an address of this machine, such as "0.0.0.0". OpenIGTLink has no
    passwords. port: 0 = any free one; `port` has its number.
    """

    def __init__(self, world, tool=None, *, tracked=None, image=None, image_every=1.0, host="127.0.0.1", port=PORT):
        if pyigtl is None:
            raise Error("OpenIGTLink: expected pyigtl, found none; pip install pyigtl")
        self.live = LiveWorld(world, tool)
        self.tracked = tracked or world.tools[self.live.tool]
        self.image, self.image_every, self.image_due = image, image_every, 0.0
        if image is not None:
            self._check_image(world[image])
        self.connections = []
        try:
            self.server = socket.create_server((host, port))
        except (OSError, OverflowError) as error:  # OverflowError: a port beyond 65535
            raise Error(f"OpenIGTLink: {host}:{port}: {getattr(error, 'strerror', error)}") from error
        self.port = self.server.getsockname()[1]
        self.accepting = threading.Thread(target=self._accept, daemon=True)
        self.accepting.start()

    def _check_image(self, body):
        if body.model != "lattice":
            raise Error(f"OpenIGTLink: image: expected a body with model = \"lattice\", which has a CT, found {body.name}, {body.model}")

    def _accept(self):
        with contextlib.suppress(OSError):  # close() ends it
            while True:
                link, _ = self.server.accept()
                link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self.connections = [c for c in self.connections if c.is_open] + [Connection(link, self._take)]

    def _take(self, name, matrix):
        if name == self.tracked:
            matrix = np.asarray(matrix, dtype=float)
            self.live.lead(TO_RAS * matrix[:3, 3] / 1e3, quaternion_of(TO_RAS[:, None] * matrix[:3, :3]))

    def send_state(self):
        """Sends the present surfaces and tools to all connected programs, and the CT if it is due."""
        world, connections = self.live.world, [c for c in self.connections if c.is_open]
        if not connections:
            return
        messages = [surface_message(world[name]) for name in world.bodies]
        messages += [tool_message(name, pose) for name, pose in zip(world.tools, self.live.poses)]
        if self.image is not None and time.monotonic() >= self.image_due:
            messages.append(image_message(f"{self.image} CT", world[self.image].deformed_volume()))
            self.image_due = time.monotonic() + self.image_every
        for connection in connections:
            for message in messages:
                connection.send(message)

    def run(self, seconds=None):
        """Runs the world in real time; sends its state after every frame."""
        self.live.run(seconds, on_frame=self.send_state)

    def close(self):
        self.live.stops = True
        with contextlib.suppress(OSError):
            self.server.shutdown(socket.SHUT_RDWR)  # ends accept()
        self.server.close()
        self.accepting.join()
        for connection in self.connections:
            connection.close()
            for thread in connection.threads:
                thread.join()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python -m turgor.openigtlink", description="A world in 3D Slicer, live.")
    parser.add_argument("scene", help="the scene, a TOML file")
    parser.add_argument("--tool", help="tool that is tracked (default: the first)")
    parser.add_argument("--tracked", help="name of the received TRANSFORM (default: the tool's name)")
    parser.add_argument("--image", help="lattice body whose deformed CT is sent")
    parser.add_argument("--image-every", type=float, default=1.0, help="seconds between CTs (default: 1)")
    parser.add_argument("--host", default="127.0.0.1", help="address to listen on (default: this machine only)")
    parser.add_argument("--port", type=int, default=PORT, help=f"port to listen on (default: {PORT})")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="key of the scene to override; may be repeated")
    parser.add_argument("--seconds", type=float, help="duration (default: until Ctrl+C)")
    given = parser.parse_args(arguments)
    try:
        world = World(given.scene, set=overrides(given.set), keeps_forces=False)
        with Bridge(world, given.tool, tracked=given.tracked, image=given.image, image_every=given.image_every, host=given.host,
                    port=given.port) as bridge:
            print(f"listening on {given.host}:{bridge.port}; {bridge.tracked} leads {world.tools[bridge.live.tool]}", flush=True)
            with contextlib.suppress(KeyboardInterrupt):
                bridge.run(given.seconds)
            print(bridge.live.summary())
    except (Error, KeyError) as error:
        print(f"turgor.openigtlink: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())

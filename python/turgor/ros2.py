"""A world as a participant of ROS 2, without an installation of ROS 2:

    python -m turgor.ros2 scenes/palpation.toml --tool finger

| topic                  | type                        | direction                                          |
|------------------------|-----------------------------|----------------------------------------------------|
| /turgor/TOOL/goal      | geometry_msgs/PoseStamped   | in: pose that leads the tool                       |
| /turgor/TOOL/wrench    | geometry_msgs/WrenchStamped | out, 1 kHz: force [N] and torque [N·m] on the tool |
| /turgor/TOOL/pose      | geometry_msgs/PoseStamped   | out, every frame                                   |
| /turgor/BODY/surface   | sensor_msgs/PointCloud2     | out, every frame: present vertices of the surface  |

Positions are in meters, in the frame "patient": LPS, x to the left, y to the back, z to the head. Messages travel by DDS
(Cyclone DDS from PyPI: pip install turgor[ros2]), in the domain ROS_DOMAIN_ID, to every ROS 2 whose middleware is a DDS.
"""
import argparse
import contextlib
import os
import re
import sys
import time

import numpy as np

from ._turgor import Error
from .live import LiveWorld, overrides
from .world import World

try:
    import cyclonedds
except ImportError:
    cyclonedds = None
else:
    from cyclonedds.core import DDSException, Policy, Qos
    from cyclonedds.domain import DomainParticipant
    from cyclonedds.pub import DataWriter
    from cyclonedds.sub import DataReader
    from cyclonedds.topic import Topic

    from . import ros2_messages as msg

FRAME = "patient"
FLOAT32 = 7  # of sensor_msgs/PointField


def ros_name(name):
    """Name of a body or a tool as ROS 2 permits it: letters, digits and underscores, no digit first."""
    name = re.sub(r"[^A-Za-z0-9_]", "_", name)
    return f"_{name}" if name[:1].isdigit() else name


def header():
    """Header with the present time of the machine."""
    now = time.time_ns()
    return msg.Header(msg.Time(now // 10**9, now % 10**9), FRAME)


def wrench_message(wrench):
    """WrenchStamped from six numbers."""
    return msg.WrenchStamped(header(), msg.Wrench(msg.Vector3(*wrench[:3].tolist()), msg.Vector3(*wrench[3:].tolist())))


def pose_message(pose):
    """PoseStamped from a position and a quaternion w, x, y, z."""
    w, x, y, z = pose[3:].tolist()
    return msg.PoseStamped(header(), msg.Pose(msg.Point(*pose[:3].tolist()), msg.Quaternion(x, y, z, w)))


def cloud_message(points):
    """PointCloud2 from (n, 3) points [m]."""
    points = np.ascontiguousarray(points, dtype="<f4")
    fields = [msg.PointField(name, 4 * axis, FLOAT32, 1) for axis, name in enumerate("xyz")]
    return msg.PointCloud2(header(), 1, len(points), fields, False, 12, 12 * len(points), points.tobytes(), True)


class Bridge:
    """Topics of a world. `live` is its LiveWorld.

    tool: the tool that /turgor/TOOL/goal leads, default the first. domain: default ROS_DOMAIN_ID, or 0.
    """

    def __init__(self, world, tool=None, *, domain=None):
        if cyclonedds is None:
            raise Error("ROS 2: expected cyclonedds, found none; pip install cyclonedds")
        self.live = LiveWorld(world, tool)
        domain = int(os.environ.get("ROS_DOMAIN_ID") or 0) if domain is None else domain
        try:
            self.participant = DomainParticipant(domain)
        except DDSException as error:
            raise Error(f"ROS 2: Cyclone DDS cannot join the domain {domain}: {error}") from error
        # reliable, so that readers of both kinds match; only the newest message is kept
        self.newest = Qos(Policy.Reliability.Reliable(10_000_000), Policy.History.KeepLast(1))
        led = ros_name(world.tools[self.live.tool])
        self.goal = DataReader(self.participant, Topic(self.participant, f"rt/turgor/{led}/goal", msg.PoseStamped),
                               qos=Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(1)))
        self.wrenches = [self._writer(f"{ros_name(name)}/wrench", msg.WrenchStamped) for name in world.tools]
        self.poses = [self._writer(f"{ros_name(name)}/pose", msg.PoseStamped) for name in world.tools]
        self.surfaces = {name: self._writer(f"{ros_name(name)}/surface", msg.PointCloud2) for name in world.bodies}

    def _writer(self, name, kind):
        return DataWriter(self.participant, Topic(self.participant, f"rt/turgor/{name}", kind), qos=self.newest)

    def _take_goal(self):
        for found in self.goal.take(1):
            if isinstance(found, msg.PoseStamped):
                p, q = found.pose.position, found.pose.orientation
                self.live.lead((p.x, p.y, p.z), (q.w, q.x, q.y, q.z))

    def _on_tick(self, wrench):
        for writer, row in zip(self.wrenches, wrench):
            writer.write(wrench_message(row))
        self._take_goal()

    def _on_frame(self):
        for writer, pose in zip(self.poses, self.live.poses):
            writer.write(pose_message(pose))
        for name, writer in self.surfaces.items():
            writer.write(cloud_message(self.live.world[name].points))

    def run(self, seconds=None):
        """Runs the world in real time: wrenches after every tick, poses and surfaces after every frame."""
        self.live.run(seconds, self._on_tick, self._on_frame)

    def close(self):
        self.live.stops = True


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python -m turgor.ros2", description="A world as a participant of ROS 2.")
    parser.add_argument("scene", help="the scene, a TOML file")
    parser.add_argument("--tool", help="tool that /turgor/TOOL/goal leads (default: the first)")
    parser.add_argument("--domain", type=int, help="domain of DDS (default: ROS_DOMAIN_ID, or 0)")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="key of the scene to override; may be repeated")
    parser.add_argument("--seconds", type=float, help="duration (default: until Ctrl+C)")
    given = parser.parse_args(arguments)
    try:
        bridge = Bridge(World(given.scene, set=overrides(given.set), keeps_forces=False), given.tool, domain=given.domain)
        print(f"/turgor/{ros_name(bridge.live.world.tools[bridge.live.tool])}/goal leads the tool", flush=True)
        with contextlib.suppress(KeyboardInterrupt):
            bridge.run(given.seconds)
        print(bridge.live.summary())
    except Error as error:
        print(f"turgor.ros2: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())

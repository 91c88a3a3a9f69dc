"""Topics of turgor.ros2, read and written by another participant of DDS over the loopback interface. The bytes of the
messages are compared with those of rosbags, which has the definitions of ROS 2."""
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import turgor
from scenes import PAD
from turgor import ros2

try:
    import rosbags.typesys as typesys
except ImportError:
    typesys = None

# Cyclone DDS on the loopback interface alone, without multicast.
LOOPBACK = ("<CycloneDDS><Domain><General><Interfaces><NetworkInterface name='lo' multicast='false'/></Interfaces></General>"
            "<Discovery><Peers><Peer address='localhost'/></Peers><ParticipantIndex>auto</ParticipantIndex></Discovery></Domain></CycloneDDS>")
DOMAIN = 20 + os.getpid() % 200
GOAL = np.array([0.03, 0.03, 0.033, 1, 0, 0, 0])  # 3 mm deep


def wait_for(what, seconds=20):
    """Result of `what()` as soon as it is true."""
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        found = what()
        if found:
            return found
        time.sleep(0.001)
    raise AssertionError(f"{what} was not true within {seconds} s")


@unittest.skipUnless(ros2.cyclonedds, "cyclonedds is not installed")
class Topics(unittest.TestCase):
    def setUp(self):
        os.environ["CYCLONEDDS_URI"] = LOOPBACK
        self.addCleanup(os.environ.pop, "CYCLONEDDS_URI")

    # A goal leads the tool into the pad; wrenches, poses and surfaces are those of the world.
    def test_goal_leads_and_wrench_returns(self):
        from cyclonedds.core import Policy, Qos

        bridge = ros2.Bridge(turgor.World(text=PAD, keeps_forces=False), domain=DOMAIN)
        other = ros2.DomainParticipant(DOMAIN)

        def topic(name, kind):
            return ros2.Topic(other, f"rt/turgor/{name}", kind)

        kept = Qos(Policy.Reliability.Reliable(10**9), Policy.History.KeepLast(100_000))  # ROS 2 is reliable by default too
        goals = ros2.DataWriter(other, topic("finger/goal", ros2.msg.PoseStamped), qos=kept)
        wrenches, poses, surfaces = (ros2.DataReader(other, topic(name, kind), qos=kept) for name, kind in (
            ("finger/wrench", ros2.msg.WrenchStamped), ("finger/pose", ros2.msg.PoseStamped), ("pad/surface", ros2.msg.PointCloud2)))
        wait_for(lambda: goals.get_matched_subscriptions() and wrenches.get_matched_publications())
        thread = threading.Thread(target=bridge.run, args=(30,))
        thread.start()
        self.addCleanup(thread.join)
        self.addCleanup(bridge.close)

        stamps = []

        def newest(reader):
            found = [message for message in reader.take(1000) if hasattr(message, "header")]
            if reader is wrenches:
                stamps.extend((message.header.stamp.sec, message.header.stamp.nanosec) for message in found)
            return found[-1] if found else None

        def is_there():
            goals.write(ros2.pose_message(GOAL))
            found, pose = newest(wrenches), newest(poses)
            return pose and abs(pose.pose.position.z - GOAL[2]) < 1e-9 and found

        self.assertEqual(wait_for(is_there).header.frame_id, "patient")
        cloud = wait_for(lambda: newest(surfaces))
        wait_for(lambda: (found := newest(wrenches)) and abs(found.wrench.force.z - bridge.live.wrench[0, 2]) < 1e-9)
        bridge.close()
        thread.join()
        newest(wrenches)
        sent = bridge.live.ticks - bridge.live.late  # a wrench after every computation; almost all arrive
        self.assertLessEqual(len(stamps), sent)
        self.assertGreater(len(stamps), 0.9 * sent - 20)
        self.assertEqual(stamps, sorted(stamps))
        self.assertGreater(bridge.live.wrench[0, 2], 0.05)
        points = np.frombuffer(bytes(cloud.data), "<f4").reshape(-1, 3)
        self.assertEqual((cloud.width, cloud.point_step), (len(points), 12))
        self.assertEqual(points.shape, bridge.live.world["pad"].points.shape)
        self.assertLess(np.abs(points - bridge.live.world["pad"].rest_points).max(), 0.004)

        # the same pose in a world of its own gives the same force
        rows = np.repeat([[GOAL]], 100, axis=0)
        rows[:60, 0, 2] = np.linspace(0.05, GOAL[2], 60)
        alone = turgor.World(text=PAD).tick(rows)[-1, 0, 2]
        np.testing.assert_allclose(bridge.live.wrench[0, 2], alone, rtol=0.02)

    # The program of the page runs a scene and prints its counts.
    def test_program_runs_scene(self):
        scene = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory())) / "pad.toml"
        scene.write_text(PAD)
        done = subprocess.run([sys.executable, "-m", "turgor.ros2", scene, "--domain", str(DOMAIN), "--seconds", "0.2"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("/turgor/finger/goal leads", done.stdout)
        self.assertIn("200 ticks", done.stdout)

    # Names of bodies and tools become names that ROS 2 permits.
    def test_names_are_permitted(self):
        self.assertEqual([ros2.ros_name(name) for name in ("finger", "left lobe-2", "3rd")], ["finger", "left_lobe_2", "_3rd"])


@unittest.skipUnless(ros2.cyclonedds and typesys, "cyclonedds or rosbags is not installed")
class Bytes(unittest.TestCase):
    # Messages have the bytes that the definitions of two versions of ROS 2 give.
    def test_messages_have_bytes_of_ros2(self):
        for version in (typesys.Stores.ROS2_HUMBLE, typesys.Stores.ROS2_JAZZY):
            store = typesys.get_typestore(version)
            kind = {name.rpartition("/")[2]: t for name, t in store.types.items()}
            head = lambda m: kind["Header"](kind["Time"](m.header.stamp.sec, m.header.stamp.nanosec), m.header.frame_id)

            wrench = ros2.wrench_message(np.array([1.5, -2, 3, 0.25, 5, -6]))
            self.compare(store, "geometry_msgs/msg/WrenchStamped", wrench, kind["WrenchStamped"](
                head(wrench), kind["Wrench"](kind["Vector3"](1.5, -2, 3), kind["Vector3"](0.25, 5, -6))))
            pose = ros2.pose_message(np.array([0.1, -0.2, 0.3, 0.5, 0.1, -0.7, 0.5]))
            self.compare(store, "geometry_msgs/msg/PoseStamped", pose, kind["PoseStamped"](
                head(pose), kind["Pose"](kind["Point"](0.1, -0.2, 0.3), kind["Quaternion"](0.1, -0.7, 0.5, 0.5))))
            for count in (0, 1, 7):
                points = np.arange(3 * count, dtype=np.float32).reshape(-1, 3)
                cloud = ros2.cloud_message(points)
                fields = [kind["PointField"](name, 4 * axis, 7, 1) for axis, name in enumerate("xyz")]
                self.compare(store, "sensor_msgs/msg/PointCloud2", cloud, kind["PointCloud2"](
                    head(cloud), 1, count, fields, False, 12, 12 * count, np.frombuffer(points.tobytes(), np.uint8), True))

    def compare(self, store, name, ours, theirs):
        self.assertEqual(bytes(ours.serialize()), bytes(store.serialize_cdr(theirs, name)), name)


if __name__ == "__main__":
    unittest.main()

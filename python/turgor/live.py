"""Worlds in real time, with tools that another program moves: the common part of turgor.openigtlink and turgor.ros2."""
import sys
import threading
import time
import tomllib

import numpy as np

from ._turgor import Error

TICK = 1e-3  # [s]
MOST_TICKS = 50  # that are made up for; longer delays slow the world down
GAP = 1e-5  # width of the bins that count gaps [s]
SWITCH = TICK / 4  # longest turn of one thread in the interpreter while another one waits [s]


def overrides(pairs):
    """Keys and values for World(set=...) from texts KEY=VALUE of a command line. A value is TOML or a text; none removes
    the key."""
    values = {}
    for pair in pairs:
        key, equals, text = pair.partition("=")
        if not equals:
            raise Error(f"--set: expected KEY=VALUE, found {pair}")
        if not text:
            values[key] = None
            continue
        try:
            values[key] = tomllib.loads(f"value = {text}")["value"]
        except tomllib.TOMLDecodeError:
            values[key] = text
    return values


def tool_index(world, name):
    """Index of a tool; None = the first one."""
    if not world.tools:
        raise Error("a live world: expected a scene with a tool, found none")
    if name is None:
        return 0
    if name not in world.tools:
        raise Error(f"a live world: expected a tool of the scene ({', '.join(world.tools)}), found {name}")
    return world.tools.index(name)


def quaternion_of(axes):
    """Quaternion w, x, y, z of a rotation matrix; None for a matrix that is not a rotation.

    The four products are the rows of the matrix 4 q qᵀ; its longest row has no cancellation [Shepperd 1978].
    """
    axes = np.asarray(axes, dtype=float)
    if not np.isfinite(axes).all() or abs(axes @ axes.T - np.eye(3)).max() > 1e-3 or np.linalg.det(axes) < 0:
        return None
    (a, b, c), (d, e, f), (g, h, i) = axes
    rows = np.array([[1 + a + e + i, h - f, c - g, d - b], [h - f, 1 + a - e - i, b + d, c + g],
                     [c - g, b + d, 1 - a + e - i, f + h], [d - b, c + g, f + h, 1 - a - e + i]])
    row = rows[np.argmax(np.diag(rows))]
    return row / np.linalg.norm(row)


def axes_of(quaternion):
    """Rotation matrix of a unit quaternion w, x, y, z."""
    w, x, y, z = quaternion
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


class LiveWorld:
    """A world that follows the clock. One tool follows poses from outside, the others follow the paths of the scene.

    fastest: limit of the led tool's speed [m/s], because a tracker may jump.
    A pose that is not finite or not a rotation is ignored and counted in `refused`. Ticks that were computed after the
    beginning of the next one are counted in `late`. `gap(share)` is the time between one wrench and the next.
    """

    def __init__(self, world, tool=None, fastest=0.5):
        self.world, self.tool, self.fastest = world, tool_index(world, tool), fastest
        self.poses = world.tool_poses.copy()
        self.goal = None  # newest pose from outside; none yet: the path of the scene
        self.ticks = self.late = self.refused = 0
        self.wrench = np.zeros((len(world.tools), 6))
        self.gaps = np.zeros(10_000, dtype=int)  # between wrenches, in bins of GAP; the last one counts longer ones too
        self.longest_gap = 0.0  # [s]
        self.stops = False

    def lead(self, position, quaternion):
        """Sets the goal of the led tool: position [m] in the patient frame, quaternion w, x, y, z. For any thread."""
        pose = np.array([*position, *quaternion], dtype=float) if quaternion is not None else np.full(7, np.nan)
        length = np.linalg.norm(pose[3:])
        if not np.isfinite(pose).all() or not length > 1e-6:
            self.refused += 1
            return
        pose[3:] /= length
        self.goal = pose

    def _count_gap(self, gap):
        self.gaps[min(int(gap / GAP), len(self.gaps) - 1)] += 1
        self.longest_gap = max(self.longest_gap, gap)

    def gap(self, share):
        """Time between one wrench and the next [s] that this share of all gaps is not above, to 10 µs; 0 without gaps."""
        total = self.gaps.sum()
        return min((np.searchsorted(np.cumsum(self.gaps), share * total) + 1) * GAP, self.longest_gap) if total else 0.0

    def summary(self):
        """A sentence with the counts of ticks and the gaps between wrenches."""
        return (f"{self.ticks} ticks, {self.late} late, {self.refused} poses refused; gaps between wrenches: p50 {1e3 * self.gap(0.5):.2f} ms, "
                f"p99 {1e3 * self.gap(0.99):.2f} ms, longest {1e3 * self.longest_gap:.2f} ms")

    def _led_poses(self, count):
        """(count, 7): the led tool on a straight line to its goal. None without a goal."""
        led, goal = self.poses[self.tool], self.goal
        if goal is None:
            return None
        way = goal[:3] - led[:3]
        reach = np.minimum(self.fastest * TICK * np.arange(1, count + 1), np.linalg.norm(way))
        return np.column_stack([led[:3] + np.outer(reach / max(np.linalg.norm(way), 1e-12), way), np.tile(goal[3:], (count, 1))])

    def tick(self, count=1):
        """Computes ticks of 1 ms. Returns (count, tools, 6): force [N] and torque [N·m] on every tool."""
        led, self.poses = self._led_poses(count), self.world.tool_poses
        poses = np.repeat(self.poses[None], count, axis=0)
        if led is not None:
            poses[:, self.tool] = led
            self.poses = poses[-1]
        wrenches = self.world.tick(poses)
        self.ticks += count
        self.wrench = wrenches[-1]
        return wrenches

    def run(self, seconds=None, on_tick=None, on_frame=None):
        """Follows the clock for `seconds`, or until `stops` is true. Ticks run on the calling thread, frames beside them on
        another one, so that no tick waits for a frame. Once for a world, which has no ticks before.

        on_tick(wrench): after every computation of the newest tick; (tools, 6). on_frame(): after every frame of the world,
        on the thread of the frames.
        """
        self.world.begin_touch()
        ended, failures = threading.Event(), []
        frames = threading.Thread(target=self._run_frames, args=(ended, failures, on_frame))
        interval = sys.getswitchinterval()
        sys.setswitchinterval(min(interval, SWITCH))
        frames.start()
        try:
            self._run_ticks(seconds, failures, on_tick)
        finally:
            ended.set()
            frames.join()
            sys.setswitchinterval(interval)
            self.world.end_touch()
        if failures:
            raise failures[0]

    def _run_ticks(self, seconds, failures, on_tick):
        total = float("inf") if seconds is None else round(seconds / TICK)
        begin, done, last = time.monotonic(), 0, None
        while done < total and not self.stops and not failures:
            due = int(min((time.monotonic() - begin) / TICK, total)) - done
            if due <= 0:
                time.sleep(max(begin + (done + 1) * TICK - time.monotonic(), 0))
                continue
            if due > MOST_TICKS:
                begin, due = begin + (due - MOST_TICKS) * TICK, MOST_TICKS
            for _ in range(due):
                poses, led = np.full_like(self.poses, np.nan), self._led_poses(1)
                if led is not None:
                    poses[self.tool] = led[0]
                self.wrench, self.poses = self.world.touch_tick(poses)
                self.ticks += 1
            done += due
            self.late += due - 1
            if on_tick:
                on_tick(self.wrench)
            now = time.monotonic()
            if last is not None:
                self._count_gap(now - last)
            last = now

    def _run_frames(self, ended, failures, on_frame):
        """Frames that are due by the ticks. A delay of more than MOST_TICKS is not made up for."""
        first, skipped = self.ticks, 0
        begin = self.world.frame
        try:
            while True:
                wait = (self.world.frame - begin + 1) * self.world.dt + (skipped - self.ticks + first) * TICK
                if wait > TICK / 2:
                    if ended.wait(wait):
                        return
                    continue
                skipped += max(0, int(-wait / TICK) - MOST_TICKS)
                self.world.step(1)
                if on_frame:
                    on_frame()
                if ended.is_set():
                    return
        except BaseException as error:  # of this thread, raised again by run()
            failures.append(error)

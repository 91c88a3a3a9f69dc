"""Environments for Gymnasium: turgor/Palpate-v0 and turgor/Retract-v0, single or vectorized.

    import gymnasium, turgor.gym

    env = gymnasium.make("turgor/Palpate-v0")
    envs = gymnasium.make_vec("turgor/Retract-v0", num_envs=64)      # one thread per world, one engine call per step

Palpate: a fingertip on a pad of soft tissue with a hidden nodule. Actions move the fingertip, observations contain its force,
and the reward grows as it presses closer to the nodule. Retract: forceps grasp a liver and pull it with 0.5 N.
"""
import gymnasium
import numpy as np

from .world import World, tick_all

TICKS = 20  # milliseconds per step


class _Task:
    """A task, for single and vectorized environments. Arrays have a row per world."""

    step_length = 1e-3  # displacement of the tool in a step of full action, along each axis [m]
    horizon = 100  # steps of an episode
    force_scale = 1.0  # of observations [N]

    def observe(self, position, force, hold):
        """Position of the tool in its box, each in [-1, 1]; force / force_scale; additional observations of the task."""
        middle, half = (self.high + self.low) / 2, (self.high - self.low) / 2
        return np.column_stack([(position - middle) / half, np.clip(force / self.force_scale, -10, 10), self.more(hold)]).astype(np.float32)

    def more(self, hold):
        return np.zeros((len(hold), 0))

    def spaces(self):
        count = 6 + self.more(np.zeros(1)).shape[1]
        observation = gymnasium.spaces.Box(-10, 10, (count,), np.float32)
        return observation, gymnasium.spaces.Box(-1, 1, (self.action_count,), np.float32)


class _Palpate(_Task):
    action_count = 3
    low, high, start = np.array([0.01, 0.01, 0.03]), np.array([0.07, 0.05, 0.041]), np.array([0.04, 0.03, 0.038])
    variants = [(x, y) for x in (0.02, 0.04, 0.06) for y in (0.02, 0.04)]  # centers of the nodule [m]
    force_scale = 0.2

    def scene(self, variant):
        x, y = self.variants[variant]
        return {"world": {"duration": 1, "frame_rate": 1000 / TICKS},
                "body": {"pad": {"model": "sfem", "block": {"size": [0.08, 0.06, 0.03], "count": [12, 9, 5]}, "fixed": "bottom",
                                 "young": 4e3, "poisson": 0.4, "cache": False, "patch": False,
                                 "inclusion": {"nodule": {"center": [x, y, 0.021], "radius": 0.008, "young": 1e5}}}},
                "tool": {"finger": {"body": "pad", "shape": {"sphere": 0.006}, "path": [[0, *self.start.tolist()]]}}}

    def rewards(self, variant, position, force, hold):
        """1 on the nodule, down to 0 at a distance of 30 mm; 0 without contact, reduced by the force above 0.5 N."""
        middle = np.array(self.variants)[variant]
        near = 1 - np.minimum(np.linalg.norm(position[:, :2] - middle, axis=1) / 0.03, 1)
        size = np.linalg.norm(force, axis=1)
        return near * (size > 1e-3) - np.maximum(size - 0.5, 0)


class _Retract(_Task):
    action_count = 4  # the fourth grasps if above 0
    variants = [None]
    pull = 0.5  # target force [N]

    def __init__(self):
        world = World(self.scene(0), threads=1)
        self.start = world.tool_poses[0, :3]
        self.turn = world.tool_poses[0, 3:]
        self.low, self.high = self.start - [0.015, 0.015, 0.012], self.start + [0.015, 0.015, 0.015]

    def scene(self, variant):
        return {"world": {"duration": 1, "frame_rate": 1000 / TICKS},
                "body": {"liver": {"model": "rhombus", "surface": {"phantom": "liver", "detail": 0.3}}},
                "tool": {"forceps": {"body": "liver", "shape": {"forceps": "phantom"},
                                     "grasp": {"at_fraction": [0.3, 0.5, 1], "depth": 0.004, "pull": 0.006, "start": 0, "duration": 0.1}}}}

    def more(self, hold):
        return np.asarray(hold, dtype=float)[:, None]

    def rewards(self, variant, position, force, hold):
        """1 at the target force, 0 without force or at twice the target, negative beyond."""
        return 1 - np.abs(-force[:, 2] - self.pull) / self.pull


class _Worlds:
    """Worlds of one task, each with its own time; common to single and vectorized environments."""

    def __init__(self, task, count):
        self.task, self.count = task, count
        self.initial = {}  # by variant: a world in its initial state
        self.worlds = [{} for _ in range(count)]  # per row, by variant: a world and its initial state
        self.variant = np.zeros(count, dtype=int)
        self.position = np.zeros((count, 3))
        self.force = np.zeros((count, 3))
        self.hold = np.zeros(count, dtype=bool)
        self.steps = np.zeros(count, dtype=int)
        self.turn = getattr(task, "turn", np.array([1.0, 0, 0, 0]))

    def _begin(self, row, variant):
        if variant not in self.initial:
            world = World(self.task.scene(variant), threads=1, keeps_forces=False)
            world.tick(np.zeros((0, 1, 7)))
            self.initial[variant] = world
        if variant not in self.worlds[row]:
            world = self.initial[variant].copy(threads=1)
            self.worlds[row][variant] = (world, world.get_state())
        world, state = self.worlds[row][variant]
        world.set_state(state)

    def reset(self, row, random):
        self.variant[row] = random.integers(len(self.task.variants))
        self._begin(row, int(self.variant[row]))
        self.position[row], self.force[row], self.hold[row], self.steps[row] = self.task.start, 0, False, 0

    def observe(self):
        return self.task.observe(self.position, self.force, self.hold)

    def step(self, rows, actions, threads):
        """Steps the worlds of these rows and returns their rewards."""
        actions = np.clip(np.asarray(actions, dtype=np.float64), -1, 1)
        goal = np.clip(self.position[rows] + self.task.step_length * actions[:, :3], self.task.low, self.task.high)
        way = (1 + np.arange(TICKS))[None, :, None] / TICKS
        poses = np.empty((len(rows), TICKS, 1, 7))
        poses[:, :, 0, :3] = self.position[rows][:, None] * (1 - way) + goal[:, None] * way
        poses[:, :, 0, 3:] = self.turn
        self.hold[rows] = actions[:, 3] > 0 if actions.shape[1] > 3 else False
        worlds = [self.worlds[row][self.variant[row]][0] for row in rows]
        forces = tick_all(worlds, poses, self.hold[rows][:, None, None], threads)
        self.position[rows], self.force[rows] = goal, forces[:, -1, 0, :3]
        self.steps[rows] += 1
        return self.task.rewards(self.variant[rows], goal, self.force[rows], self.hold[rows])


class Environment(gymnasium.Env):
    """One world. Observations: position of the tool in its box, each in [-1, 1], and its force; actions: its displacement in a step."""

    metadata = {"render_modes": []}

    def __init__(self, task, render_mode=None):
        self.task = task()
        self.observation_space, self.action_space = self.task.spaces()
        self.worlds = _Worlds(self.task, 1)
        self.render_mode = render_mode

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        self.worlds.reset(0, self.np_random)
        return self.worlds.observe()[0], {}

    def step(self, action):
        reward = self.worlds.step([0], [action], 1)
        over = bool(self.worlds.steps[0] >= self.task.horizon)
        return self.worlds.observe()[0], float(reward[0]), False, over, {"force_N": self.worlds.force[0].copy()}


class VectorEnvironment(gymnasium.vector.VectorEnv):
    """Many worlds, each on one thread; a finished episode restarts in the next step."""

    metadata = {"render_modes": [], "autoreset_mode": gymnasium.vector.AutoresetMode.NEXT_STEP}

    def __init__(self, task, num_envs=1, threads=0, render_mode=None):
        self.task, self.num_envs, self.threads, self.render_mode = task(), num_envs, threads, render_mode
        self.single_observation_space, self.single_action_space = self.task.spaces()
        batch = gymnasium.vector.utils.batch_space
        self.observation_space, self.action_space = batch(self.single_observation_space, num_envs), batch(self.single_action_space, num_envs)
        self.worlds = _Worlds(self.task, num_envs)
        self.randoms = [np.random.default_rng() for _ in range(num_envs)]
        self.over = np.zeros(num_envs, dtype=bool)

    def reset(self, *, seed=None, options=None):
        if seed is not None:
            seeds = [seed + n for n in range(self.num_envs)] if np.isscalar(seed) else seed
            self.randoms = [gymnasium.utils.seeding.np_random(s)[0] for s in seeds]
        for row in range(self.num_envs):
            self.worlds.reset(row, self.randoms[row])
        self.over[:] = False
        return self.worlds.observe(), {}

    def step(self, actions):
        rewards = np.zeros(self.num_envs)
        active = np.flatnonzero(~self.over)
        for row in np.flatnonzero(self.over):
            self.worlds.reset(row, self.randoms[row])
        if len(active):
            rewards[active] = self.worlds.step(active, np.asarray(actions)[active], self.threads)
        self.over = self.worlds.steps >= self.task.horizon
        return self.worlds.observe(), rewards, np.zeros(self.num_envs, dtype=bool), self.over.copy(), {"force_N": self.worlds.force.copy()}


def _single(task):
    return lambda **settings: Environment(task, **settings)


def _vector(task):
    return lambda **settings: VectorEnvironment(task, **settings)


def register():
    """Registers the environments with Gymnasium; called on import of this module."""
    for name, task in (("Palpate", _Palpate), ("Retract", _Retract)):
        if f"turgor/{name}-v0" not in gymnasium.registry:
            gymnasium.register(f"turgor/{name}-v0", entry_point=_single(task), vector_entry_point=_vector(task))


register()

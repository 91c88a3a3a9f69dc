"""How much slower a world is among many: python benches/gym_worlds.py [worlds]

Steps of turgor/Palpate-v0 and turgor/Retract-v0 by worlds and second, with 64 worlds and with one on each core.
"""
import os
import sys
import time

import gymnasium
import numpy as np

import turgor.gym  # noqa: F401: makes the environments known


def rate(name, count, steps=90):
    """Worlds · steps a second: the best of three, since others may be at the machine."""
    envs = gymnasium.make_vec(name, num_envs=count)
    actions = np.zeros((steps, *envs.action_space.shape), dtype=np.float32)
    actions[:, :, 2] = np.where(np.arange(steps) % 30 < 15, -1, 1)[:, None]
    best = 0
    for _ in range(3):
        envs.reset(seed=0)
        begin = time.perf_counter()
        for action in actions:
            envs.step(action)
        best = max(best, count * steps / (time.perf_counter() - begin))
    return best


many, cores = int(sys.argv[1]) if len(sys.argv) > 1 else 64, os.cpu_count()
for name in ("turgor/Palpate-v0", "turgor/Retract-v0"):
    alone, together = rate(name, cores), rate(name, many)
    print(f"{name}: {cores} worlds {alone:.0f} steps/s, {many} worlds {together:.0f} steps/s on {cores} cores: {together / alone:.2f} times as fast a world")

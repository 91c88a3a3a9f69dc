"""Throughput of many gym worlds: python benches/gym_worlds.py [worlds]

Measures steps per second of turgor/Palpate-v0 and turgor/Retract-v0 with one world per core and with 64 (or `worlds`) worlds.
"""
import os
import sys
import time

import gymnasium
import numpy as np

import turgor.gym  # noqa: F401: registers the environments


def rate(name, count, steps=90):
    """Steps per second of all worlds; best of three, because other programs may use the machine."""
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
    print(f"{name}: {cores} worlds {alone:.0f} steps/s, {many} worlds {together:.0f} steps/s on {cores} cores: speedup {together / alone:.2f}")

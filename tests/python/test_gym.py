"""Environments for Gymnasium."""
import unittest
import warnings

import numpy as np

try:
    import gymnasium
    from gymnasium.utils.env_checker import check_env

    import turgor.gym
except ImportError:
    gymnasium = None

NAMES = ("turgor/Palpate-v0", "turgor/Retract-v0")


@unittest.skipUnless(gymnasium, "gymnasium is not installed")
class Environments(unittest.TestCase):
    # The environments pass Gymnasium's checker without warnings.
    def test_environments_pass_gymnasium_check(self):
        for name in NAMES:
            with self.subTest(name), warnings.catch_warnings():
                warnings.simplefilter("error")
                warnings.filterwarnings("ignore", message=".*render mode.*|.*different from the unwrapped.*")
                check_env(gymnasium.make(name).unwrapped, skip_render_check=True)

    # A vector environment gives the observations and rewards of single environments.
    def test_vector_environment_matches_single_ones(self):
        for name in NAMES:
            with self.subTest(name):
                envs = gymnasium.make_vec(name, num_envs=5)
                self.assertIsInstance(envs.unwrapped, turgor.gym.VectorEnvironment)
                single = [gymnasium.make(name) for _ in range(5)]
                together, _ = envs.reset(seed=3)
                alone = [env.reset(seed=3 + n)[0] for n, env in enumerate(single)]
                np.testing.assert_array_equal(together, alone)
                actions = np.random.default_rng(1).uniform(-1, 1, (15, *envs.action_space.shape)).astype(np.float32)
                actions[:, :, 2] = np.where(np.arange(15) < 10, -0.9, 0.5)[:, None]
                forces = 0
                for action in actions:
                    observed, rewards, _, _, _ = envs.step(action)
                    answers = [env.step(a) for env, a in zip(single, action)]
                    np.testing.assert_array_equal(observed, [a[0] for a in answers])
                    np.testing.assert_array_equal(rewards, [a[1] for a in answers])
                    forces = max(forces, np.abs(observed[:, 3:6]).max())
                self.assertGreater(forces, 0.05)

    # A finished episode restarts with its first observation.
    def test_finished_episode_restarts(self):
        envs = gymnasium.make_vec("turgor/Retract-v0", num_envs=2)
        first, _ = envs.reset(seed=1)
        idle = np.zeros(envs.action_space.shape, dtype=np.float32)
        idle[:, 2] = -1
        for n in range(100):
            observed, _, _, over, _ = envs.step(idle)
            self.assertEqual(over.tolist(), [n == 99] * 2)
        self.assertGreater(np.abs(observed - first).max(), 0.1)
        observed, rewards, _, over, _ = envs.step(idle)
        np.testing.assert_array_equal(observed, first)
        self.assertEqual((rewards.tolist(), over.tolist()), ([0, 0], [False, False]))

    # Pressing the nodule gives a larger force and a larger reward than pressing elsewhere.
    def test_pressing_nodule_gives_force_and_reward(self):
        env = gymnasium.make("turgor/Palpate-v0").unwrapped
        env.reset(seed=0)
        middle = env.task.variants[env.worlds.variant[0]]
        forces, rewards = [], []
        for goal in (middle, (0.08 - middle[0] if middle[0] != 0.04 else 0.02, 0.06 - middle[1])):
            env.reset(seed=0)
            for _ in range(40):
                direction = (np.array(goal) - env.worlds.position[0, :2]) / env.task.step_length
                env.step(np.array([*np.clip(direction, -1, 1), 0], dtype=np.float32))
            for _ in range(4):
                _, reward, _, _, info = env.step(np.array([0, 0, -1], dtype=np.float32))
            forces.append(info["force_N"][2])
            rewards.append(reward)
        self.assertGreater(forces[0], 1.1 * forces[1])
        self.assertGreater(forces[1], 0.01)
        self.assertGreater(rewards[0], 0.9)
        self.assertLess(rewards[1], 0.5)

    # Forceps that hold the tissue can pull with the goal force.
    def test_holding_forceps_pull_with_goal_force(self):
        env = gymnasium.make("turgor/Retract-v0").unwrapped
        env.reset(seed=0)
        best = -1
        for lift, hold, steps in ((-1, -1, 6), (0, 1, 18), (0.5, 1, 40)):
            for _ in range(steps):
                _, reward, _, _, info = env.step(np.array([0, 0, lift, hold], dtype=np.float32))
                best = max(best, reward)
        self.assertGreater(best, 0.8)
        self.assertLess(info["force_N"][2], -0.1)


if __name__ == "__main__":
    unittest.main()

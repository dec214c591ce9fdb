# /// script
# requires-python = ">=3.11"
# dependencies = ["gymnasium>=1.0"]
# ///
"""A Gymnasium environment over any compiled closed robot: its actuators are to bring it to a random posture.

Between two actions the robot moves in machine code (`cutjoint.compiled_plant`), its loops closed.  What comes near a
singularity, where the actuators lose it, ends the episode; so does leaving the joint limits.

cutjoint itself comes from a checkout: pip install '.[compile]' gymnasium
"""

import time
import warnings

import gymnasium
import numpy as np
from gymnasium.utils.env_checker import check_env

import cutjoint
from cutjoint.errors import CutjointError

SPAN, STEPS = 0.01, 200


class Reach(gymnasium.Env):
    """Actions are efforts, from -1 to 1 of `most` [N] or [N m] about those that hold the robot at home; observations
    are the actuated coordinates, their velocities, and how far they are from the goal, shape (3 n,) [m] or [rad]."""

    def __init__(self, robot="fivebar", most=2.0, spread=0.3):
        self.chain = cutjoint.load(robot)
        self.compiled = self.chain.compile()
        self.plant = cutjoint.compiled_plant(self.compiled)
        self.hold, self.most = self.chain.terms(self.chain.home).gravity, most
        self.places = [self._anywhere(seed, spread) for seed in range(100)]
        self.observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (3 * self.chain.n,), dtype=np.float64)
        self.action_space = gymnasium.spaces.Box(-1.0, 1.0, (self.chain.n,), dtype=np.float32)

    def reset(self, *, seed=None, options=None):
        super().reset(seed=seed)
        start, goal = (self.places[k] for k in self.np_random.integers(len(self.places), size=2))
        self.goal, self.state, self.count = goal.q, self.plant.start(start, np.zeros(self.chain.n)), 0
        return self._seen()[0], {}

    def step(self, action):
        effort = self.hold + self.most * np.clip(np.asarray(action, dtype=np.float64), -1.0, 1.0)
        try:
            moved = self.plant.advance(self.state, effort, SPAN, SPAN)
        except CutjointError:
            moved = None
        lost = moved is None or self.chain.goes_beyond(self.state.q, moved.state.q)
        self.state, self.count = self.state if lost else moved.state, self.count + 1
        seen, distance = self._seen()
        reward = -10.0 if lost else -distance - 1e-3 * float(np.square(action).sum())
        return seen, reward, bool(lost), self.count >= STEPS, {"distance": distance}

    def _anywhere(self, seed, spread):
        """A closed posture around home."""
        random = np.random.default_rng(seed)
        while True:
            try:
                return self.chain.close(self.chain.home.q + spread * random.uniform(-1.0, 1.0, self.chain.n))
            except CutjointError:
                continue

    def _seen(self):
        q, v = self.plant.measured(self.state)
        return np.concatenate([q, v, self.goal - q]), float(np.linalg.norm(self.goal - q))


def rolled(env, seed, steps):
    """Observations of random actions, shape (steps, ...), with new episodes where one ends."""
    env.action_space.seed(seed)
    seen, _ = env.reset(seed=seed)
    found = []
    for _ in range(steps):
        seen, _, lost, late, _ = env.step(env.action_space.sample())
        found.append(seen)
        if lost or late:
            env.reset()
    return np.array(found)


def main():
    """Check the environment as Gymnasium does, that its seeds repeat, and how quick it is."""
    env = Reach()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*(infinity|precision).*")
        check_env(env, skip_render_check=True)
    first, again, other = rolled(env, 7, 500), rolled(env, 7, 500), rolled(env, 8, 500)
    assert np.array_equal(first, again), "the same seed gave other episodes"
    assert not np.array_equal(first, other), "another seed gave the same episodes"

    start = time.perf_counter()
    rolled(env, 0, 5000)
    rate = 5000 / (time.perf_counter() - start)
    env.reset(seed=0)
    env.step(np.ones(env.chain.n))
    gap = max(env.chain.gap(env.state.q))
    print(f"check_env passed; seeds repeat; {rate:.0f} steps of {SPAN} s a second, loops open by {gap:.1e}")
    assert gap < 1e-9
    assert rate > 200.0, "compiled code steps thousands of times a second"


if __name__ == "__main__":
    main()

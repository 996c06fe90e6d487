"""The same environment flies through AirSim's protocol."""

from dataclasses import asdict

import numpy as np
from served import serving_mission

from crosstrack.learn.arenas import forest
from crosstrack.learn.avoid import Avoid
from crosstrack.learn.randomise import NOMINAL
from crosstrack.learn.single import Single
from crosstrack.mission.load import from_document
from crosstrack.vehicles.airsim.vehicle import AirSim

TASK = Avoid(randomise=NOMINAL, noise=0.0)
ARENA = forest(0.05, 3)
STEPS = 40


def flown(env: Single) -> np.ndarray:
    """Return what is seen during an episode of steady flight, (steps, size)."""
    seen = [env.reset(seed=1)[0]]
    for _ in range(STEPS):
        observation, _, terminated, truncated, _ = env.step(np.array([0.7, 0.2, 0.1]))
        assert not terminated
        assert not truncated
        seen.append(observation)
    return np.array(seen)


def test_an_episode_on_the_server_is_that_of_the_embedded_simulator() -> None:
    mission = from_document(
        {
            "start": {"position": list(ARENA.start)},
            "route": [list(ARENA.goal)],
            "world": dict(ARENA.world),
            "sensors": [{"kind": "lidar", **asdict(TASK.sensor)}],
            "vehicle": {"kind": "airsim"},
        }
    )
    embedded = flown(Single(TASK, arena=ARENA))
    with serving_mission(mission) as server:
        env = Single(TASK, AirSim(port=server.port, draw=False), ARENA)
        first, second = flown(env), flown(env)
        env.close()
    np.testing.assert_allclose(first, second, atol=1e-5)
    motion = TASK.rays
    np.testing.assert_allclose(first[:, motion : motion + 7], embedded[:, motion : motion + 7], atol=0.12)
    hits = (first[:, :motion] < 1) & (embedded[:, :motion] < 1)
    assert hits.mean() > 0.02
    assert np.median(np.abs(first[:, :motion] - embedded[:, :motion])[hits]) < 0.03

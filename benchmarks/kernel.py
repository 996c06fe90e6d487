"""Physics steps per second of the kernel, autopilot included, beside MuJoCo without one, in the same run.

Run as `python -m benchmarks.kernel`. Speeds drift, so the cases take turns, and ratios are those of a turn.
"""

import statistics
import time
from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np

from crosstrack.sim.airframe import GENERIC
from crosstrack.sim.fleet import MOTION, fleet, place
from crosstrack.sim.kernel import STEP, fly
from crosstrack.types import GRAVITY, Air, Limits

RATE = 50
"""Hz, of the commands"""
ROUNDS = 9
FLEET = 1024


def hovering(count: int) -> Any:
    """Return vehicles in flight, each with a velocity to hold."""
    rows: Any = fleet(GENERIC, Air(), Limits(), ground=0.0, count=count)
    place(rows, np.array([0.0, 0.0, 1000.0]), 0.0)
    rows["level"] = MOTION
    rows["command"][:, 3:6] = np.random.default_rng(0).uniform(-3, 3, (count, 3))
    return rows


def kernel(count: int, calls: int) -> Callable[[], float]:
    """Return a round of `calls` commands that answers with its physics steps per second."""
    rows, steps = hovering(count), round(1 / (RATE * STEP))
    fly(rows, STEP, steps)

    def run() -> float:
        start = time.perf_counter()
        for _ in range(calls):
            fly(rows, STEP, steps)
        return count * steps * calls / (time.perf_counter() - start)

    return run


def oracle(calls: int) -> Callable[[], float]:
    """Return the same for a free body with four motors in MuJoCo, stepped by its own loop."""
    motors = "".join(f'<motor site="r{i}" gear="0 0 1 0 0 {spin}"/>' for i, spin in enumerate(GENERIC.spins))
    sites = "".join(f'<site name="r{i}" pos="{x} {y} {z}"/>' for i, (x, y, z) in enumerate(GENERIC.rotor_positions))
    inertia = " ".join(map(str, GENERIC.inertia))
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="{STEP}" integrator="RK4" gravity="0 0 {-GRAVITY}"/>
        <worldbody><body><freejoint/>
          <inertial pos="0 0 0" mass="{GENERIC.mass}" diaginertia="{inertia}"/>{sites}
        </body></worldbody><actuator>{motors}</actuator></mujoco>"""
    )
    data, steps = mujoco.MjData(model), round(1 / (RATE * STEP))
    data.ctrl[:] = GENERIC.mass * GRAVITY / 4

    def run() -> float:
        start = time.perf_counter()
        for _ in range(calls):
            mujoco.mj_step(model, data, nstep=steps)
        return steps * calls / (time.perf_counter() - start)

    return run


def main() -> None:
    cases = {
        "MuJoCo, one body": oracle(600),
        "one vehicle": kernel(1, 30000),
        f"{FLEET} vehicles": kernel(FLEET, 60),
    }
    rounds = [{name: run() for name, run in cases.items()} for _ in range(ROUNDS)]
    base, *_ = cases
    print(f"{'':18} {'steps/s':>12} {'to MuJoCo: median':>18} {'least':>8} {'most':>8}")
    for name in cases:
        speed = statistics.median(one[name] for one in rounds)
        ratios = sorted(one[name] / one[base] for one in rounds)
        print(f"{name:18} {speed:12,.0f} {statistics.median(ratios):18.1f} {ratios[0]:8.1f} {ratios[-1]:8.1f}")


if __name__ == "__main__":
    main()

"""The clock in lockstep: it advances as clients ask, and what they do can be repeated bit for bit."""

import asyncio
from typing import Any

import pytest

from crosstrack.airsim.scene.scene import Scene
from crosstrack.airsim.server.clock import FRAME, TICK, Clock
from crosstrack.airsim.server.handlers import clock, flight, state
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.airsim.structs import Pose, YawMode
from crosstrack.world.world import World

CALLS = {**flight.HANDLERS, **state.HANDLERS, **clock.HANDLERS}
AS_IT_IS = YawMode(True, 0.0)


class Script:
    """A client in the loop of the server."""

    def __init__(self) -> None:
        self.simulator = Simulator(Scene(World()), Clock(lockstep=True))
        self.simulator.add_vehicle("SimpleFlight", Pose())

    def __call__(self, name: str, *arguments: Any) -> Any:
        return CALLS[name](self.simulator, *arguments)

    def run(self) -> None:
        """Fly it."""

        async def both() -> None:
            driver = asyncio.create_task(self.simulator.run())
            try:
                await asyncio.wait_for(self.fly(), 60)
            finally:
                driver.cancel()

        asyncio.run(both())

    async def fly(self) -> None:
        """Do what the script does."""
        raise NotImplementedError

    @property
    def now(self) -> float:
        """s"""
        return 1e-9 * self.simulator.now


class Tour(Script):
    """Takes off, flies a path and lands, one call after another."""

    async def fly(self) -> None:
        self("enableApiControl", True, "")
        await self("takeoff", 20.0, "")
        await self("moveToPosition", 10.0, 5.0, -8.0, 4.0, 3e38, 0, AS_IT_IS, -1.0, 1.0, "")
        await self("moveByVelocityZ", 2.0, 1.0, -8.0, 3.0, 1, YawMode(False, 0.0), "")
        await self("hover", "")
        await self("land", 60.0, "")


def test_scripts_of_joined_calls_repeat_bit_for_bit() -> None:
    tours = [Tour(), Tour()]
    for tour in tours:
        tour.run()
    assert tours[0].simulator.now == tours[1].simulator.now > 10e9
    assert tours[0].simulator.rows.tobytes() == tours[1].simulator.rows.tobytes()


class Stepped(Script):
    """Acts while a move is under way, by pauses."""

    def __init__(self, wait: float) -> None:
        super().__init__()
        self.wait = wait
        self.seen: list[bytes] = []

    async def fly(self) -> None:
        self("enableApiControl", True, "")
        self("simPause", True)
        task = self("takeoff", 20.0, "")
        for _ in range(40):
            await self("simContinueForTime", 0.1)
            await asyncio.sleep(self.wait)
            self.seen.append(self.simulator.rows.tobytes())
        assert task.done()


def test_what_is_done_between_pauses_repeats_however_long_they_take() -> None:
    runs = [Stepped(0.0), Stepped(0.002)]
    for one in runs:
        one.run()
    assert runs[0].seen == runs[1].seen
    assert len(set(runs[0].seen)) == 40


class Still(Script):
    """Has nothing under way."""

    async def fly(self) -> None:
        self("enableApiControl", True, "")
        await asyncio.sleep(0.02)
        assert self.now == 0.0
        self("simPause", True)
        task = self("takeoff", 20.0, "")
        await asyncio.sleep(0.02)
        assert self.now == 0.0
        self("simPause", False)
        await task
        ended = self.now
        await asyncio.sleep(0.02)
        assert self.now == ended > 3.0


def test_the_clock_stands_still_while_nothing_is_under_way_or_it_is_paused() -> None:
    Still().run()


class Steps(Script):
    """Steps by a time that is no multiple of a tick."""

    async def fly(self) -> None:
        for k in range(1, 101):
            await self("simContinueForTime", 0.02)
            assert self("simIsPaused")
            assert 0.02 * k <= self.now + 1e-12 < 0.02 * k + 1e-9 * TICK
        for _ in range(6):
            await self("simContinueForTime", 0.001)
        assert self.now == pytest.approx(2.006, abs=1e-9 * TICK)
        before = self.now
        await self("simContinueForTime", 0.0)
        await self("simContinueForTime", -5.0)
        assert self.now == pytest.approx(before, abs=1e-9 * TICK)
        await self("simContinueForFrames", 30)
        assert self.now == pytest.approx(before + 30 * FRAME, abs=2e-9 * TICK)


def test_steps_add_up() -> None:
    Steps().run()


class Interrupted(Script):
    """Pauses, and unpauses, while it runs for a time."""

    async def fly(self) -> None:
        run = self("simContinueForTime", 1e9)
        await asyncio.sleep(0.01)
        self("simPause", True)
        await run
        assert 0 < self.now < 1e9


def test_a_run_for_a_time_ends_with_a_pause() -> None:
    Interrupted().run()


class Alternating(Script):
    """Commands every 20 ms, as learning does, with the state in between."""

    async def fly(self) -> None:
        self("enableApiControl", True, "")
        await self("takeoff", 20.0, "")
        for k in range(200):
            await self("moveByVelocity", 1.0 if k < 100 else -1.0, 0.0, 0.0, 0.02, 0, AS_IT_IS, "")
        assert abs(self("getMultirotorState", "").kinematics_estimated.linear_velocity[0] + 1.0) < 0.4


def test_short_moves_in_a_row_are_one_long_one() -> None:
    script = Alternating()
    script.run()
    assert script.now > 200 * 0.02

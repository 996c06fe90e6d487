"""What the firmware sees to by itself: whose goals count, holding still for want of commands, whether it flies."""

from crosstrack.airsim.firmware import sticks
from crosstrack.airsim.firmware.rows import HOLD_MODE, Rows
from crosstrack.compiled import compiled

GOAL_TIMEOUT = 60
"""ms, without a command in the air, after which it holds its position"""
FLYING_THROTTLE = 0.1
"""the mean signal of the motors above which it may be flying"""
STILL = 0.08
"""m/s and rad/s, below which it is taken to stand"""
MOVING = 0.01
"""m/s, up or down, above which it is taken to have left the ground"""


@compiled
def follow_sticks(p: Rows) -> None:
    """Take the goals of the sticks."""
    for axis in range(4):
        p.goal[axis], p.mode[axis] = p.stick_goal[axis], p.stick_mode[axis]


@compiled
def hold(p: Rows) -> None:
    """Hold the position where it is now."""
    p.goal[0], p.goal[1], p.goal[2], p.goal[3] = p.position[1], p.position[0], 0.0, p.position[2]
    for axis in range(4):
        p.mode[axis] = HOLD_MODE[axis]
    p.timed_out = True


@compiled
def judge(p: Rows) -> None:
    """Find out whether it flies: from the throttle of the last update and its motion."""
    throttle = 0.25 * (p.signal[0] + p.signal[1] + p.signal[2] + p.signal[3])
    if p.flying and throttle <= FLYING_THROTTLE:
        still = True
        for k in range(3):
            still = still and abs(p.rate[k]) < STILL and abs(p.velocity[k]) < STILL
        p.flying = not still
    if not p.flying:
        p.flying = throttle > FLYING_THROTTLE and abs(p.velocity[2]) > MOVING


@compiled
def watch(p: Rows, now: int) -> None:
    """Update the goals at a time (ms)."""
    sticks.read(p, now)
    if not p.controlled:
        follow_sticks(p)
    elif p.flying and not p.timed_out and now - p.goal_time > GOAL_TIMEOUT:
        hold(p)
    judge(p)

"""What the actions of a policy mean: laws from numbers to commands of the autopilot.

Between actions a policy has asked for something, `asked` (4,): three numbers of the order of 1, and a heading (rad).

`velocity` (3,)  ahead and to the left over the speed allowed, at most 1 together; up over CLIMB; the heading turns to
                 where that leads, so that the vehicle looks where it flies. asked: the action, the heading.
`stick` one of 27  throttle, pitch and yaw, each one notch down, held, or one notch up: the rate of climb asked for, the
                 speed ahead asked for, the heading asked for; the autopilot banks. asked: speed ahead over that
                 allowed, 0, rate of climb over CLIMB, the heading.
`attitude` (4,)  roll and pitch over TILT, rate of yaw over TURN, thrust: (1 + LIFT a) g. asked: roll, pitch, thrust,
                 the heading.
"""

import math

from crosstrack.compiled import compiled
from crosstrack.policy.motion import heading
from crosstrack.types import GRAVITY, Array

VELOCITY, STICK, ATTITUDE = 0, 1, 2
KINDS = {"velocity": VELOCITY, "stick": STICK, "attitude": ATTITUDE}
SIZES = {"velocity": 3, "stick": 1, "attitude": 4}
"""numbers of an action"""
CHOICES = {"stick": 27}
"""of the kinds that choose one of so many"""
MOTION_LEVEL, ATTITUDE_LEVEL = 0, 1
"""What the numbers of a command are: position, velocity, acceleration (m, s), yaw and yaw rate (rad, s), NaN where left
to the autopilot; or attitude xyzw and thrust (m/s²)."""

CLIMB = 1.0
"""m/s"""
TILT = 0.5
"""rad"""
TURN = 2.4
"""rad/s, the fastest that the heading asked for turns"""
LIFT = 0.6
"""1"""
SLOW = 0.3
"""of the speed allowed, below which the heading is held"""
NOTCH_SPEED, NOTCH_CLIMB = 2.5, 5.0
"""1/s, by how much of what is allowed a stick changes what is asked for"""


@compiled
def bounded(value: float, low: float, high: float) -> float:
    """Return a number within limits."""
    return min(high, max(low, value))


@compiled
def wrapped(angle: float) -> float:
    """Return an angle in [-π, π)."""
    return angle - 2 * math.pi * math.floor(angle / (2 * math.pi) + 0.5)


@compiled
def steer(
    kind: int,
    action: Array,
    body: Array,
    speed: float,
    duration: float,
    asked: Array,
    command: Array,
) -> int:
    """Write the command (11,) of an action, and what is asked for (4,) now; return the level of the command.

    Args:
        kind: VELOCITY, STICK or ATTITUDE
        action: (3,), (1,) or (4,)
        body: (13,) position (m), velocity (m/s), attitude xyzw, body rate (rad/s)
        speed: m/s, allowed
        duration: s, from one action to the next
        asked: (4,) changed in place
        command: (11,) changed in place
    """
    for k in range(11):
        command[k] = math.nan
    most = TURN * duration
    if kind == ATTITUDE:
        return tilted(action, most, asked, command)
    if kind == STICK:
        choice = int(action[0])
        throttle, pitch, yaw = choice // 9 - 1, choice // 3 % 3 - 1, choice % 3 - 1
        asked[0] = bounded(asked[0] + pitch * NOTCH_SPEED * duration, 0.0, 1.0)
        asked[1] = 0.0
        asked[2] = bounded(asked[2] + throttle * NOTCH_CLIMB * duration, -1.0, 1.0)
        asked[3] = wrapped(asked[3] + yaw * most)
        c, s = math.cos(asked[3]), math.sin(asked[3])
    else:
        size = math.sqrt(action[0] * action[0] + action[1] * action[1])
        scale = 1.0 / size if size > 1.0 else 1.0
        asked[0], asked[1], asked[2] = action[0] * scale, action[1] * scale, action[2]
        c, s = heading(body)
        if size > SLOW:
            turn = wrapped(math.atan2(s, c) + math.atan2(action[1], action[0]) - asked[3])
            asked[3] = wrapped(asked[3] + bounded(turn, -most, most))
    command[3] = speed * (c * asked[0] - s * asked[1])
    command[4] = speed * (s * asked[0] + c * asked[1])
    command[5] = CLIMB * asked[2]
    command[9] = asked[3]
    return MOTION_LEVEL


@compiled
def tilted(action: Array, most: float, asked: Array, command: Array) -> int:
    """Write the attitude, yaw after pitch after roll, and thrust of an action; return the level."""
    asked[0], asked[1], asked[2] = action[0], action[1], action[3]
    asked[3] = wrapped(asked[3] + action[2] * most)
    cr, sr = math.cos(0.5 * TILT * action[0]), math.sin(0.5 * TILT * action[0])
    cp, sp = math.cos(0.5 * TILT * action[1]), math.sin(0.5 * TILT * action[1])
    cy, sy = math.cos(0.5 * asked[3]), math.sin(0.5 * asked[3])
    command[0] = sr * cp * cy - cr * sp * sy
    command[1] = cr * sp * cy + sr * cp * sy
    command[2] = cr * cp * sy - sr * sp * cy
    command[3] = cr * cp * cy + sr * sp * sy
    command[4] = GRAVITY * (1 + LIFT * action[3])
    return ATTITUDE_LEVEL

"""The firmware's remote control: goals from sticks while the API has no control, arming and disarming by gestures."""

import math

from crosstrack.airsim.firmware.cascade import TILT_LIMIT
from crosstrack.airsim.firmware.rows import ANGLE, ARMED, ARMING, DIRECT, DISARMED, DISARMING, INACTIVE, RATE, Rows
from crosstrack.compiled import compiled

INTERVAL = 10
"""ms, that must pass between two readings"""
HOLD = 100
"""ms, for which a gesture must be held"""
TOLERANCE = 0.1
"""of the full travel of a stick, in a gesture"""
IDLE = 0.1 / 1.5
"""the least throttle while armed"""
ARMED_THROTTLE = 0.1
"""the throttle while being armed"""
RATE_SWITCH = 0.3
"""of the switch, from which on the sticks mean rates"""
NONE, ARM, DISARM, NEUTRAL = range(4)


@compiled
def gesture(roll: float, pitch: float, yaw: float, throttle: float) -> int:
    """Return what the sticks ask for: sticks down and in arm, down and out disarm."""
    low, full = throttle <= TOLERANCE and 0.5 * (pitch + 1) >= 1 - TOLERANCE, 1 - TOLERANCE
    if low and yaw >= full and roll <= -full:
        return ARM
    if low and yaw <= -full and roll >= full:
        return DISARM
    still = abs(roll) <= TOLERANCE and abs(pitch) <= TOLERANCE and abs(yaw) <= TOLERANCE
    return NEUTRAL if still else NONE


@compiled
def choose_mode(p: Rows) -> None:
    """Set what the sticks mean by their switch."""
    if not p.connected:
        p.stick_goal[0] = p.stick_goal[1] = p.stick_goal[2] = 0.0
        return
    if math.isnan(p.stick_switch) or p.stick_switch != p.channels[4]:
        p.stick_switch = p.channels[4]
        level = p.stick_switch < RATE_SWITCH
        p.stick_mode[0] = p.stick_mode[1] = ANGLE if level else RATE
        p.stick_mode[2], p.stick_mode[3] = RATE, DIRECT


@compiled
def held(p: Rows, asked: bool, passed: int) -> bool:
    """Return whether a gesture has been held for long enough."""
    if asked:
        p.request_time += passed
    done = p.request_time > HOLD
    if done:
        p.request_time = 0
    return bool(done)


@compiled
def read(p: Rows, now: int) -> None:
    """Take in the sticks at a time (ms); without any, all stand at zero."""
    passed = now - p.stick_time
    if passed <= INTERVAL:
        return
    p.stick_time = now
    on = 1.0 if p.connected else 0.0
    roll, pitch, yaw, throttle = on * p.channels[0], on * p.channels[1], on * p.channels[2], on * p.channels[3]
    choose_mode(p)
    action, goal = gesture(roll, pitch, yaw, throttle), p.stick_goal
    if p.armed == ARMED and action != DISARM:
        p.request_time = 0
        goal[0], goal[1], goal[2] = TILT_LIMIT * roll, TILT_LIMIT * pitch, math.pi * yaw
        goal[3] = max(throttle, IDLE)
    elif p.armed == ARMED:
        p.armed = DISARMING if held(p, True, passed) else ARMED
    elif p.armed == INACTIVE:
        p.armed = ARMING if held(p, action == ARM, passed) else INACTIVE
    elif p.armed == ARMING:
        goal[0] = goal[1] = goal[2] = 0.0
        goal[3] = ARMED_THROTTLE
        p.armed = ARMED if held(p, action == NEUTRAL, passed) else ARMING
    else:
        goal[0] = goal[1] = goal[2] = 0.0
        if p.armed == DISARMED:
            goal[3] = 0.0
        p.armed = DISARMED if p.armed == DISARMING else INACTIVE
        p.request_time = 0

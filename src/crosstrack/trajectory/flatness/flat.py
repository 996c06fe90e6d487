"""What a quadrotor must do to fly a trajectory: attitude, thrust and body rates follow from its derivatives.

With the velocity v, the airspeed v - w, gravity g, and the drag D = diag(d) per mass in body axes, Newton's law over
mass is

    a + g e_z = c z_B - R D Rᵀ (v - w).

Its parts along the body axes, and a yaw ψ that the horizontal part of x_B points along, fix the attitude:

    x_B ∝ y_C × (a + g e_z + d_x (v - w)),    y_B ∝ (a + g e_z + d_y (v - w)) × x_B,    z_B = x_B × y_B,
    c = z_B · (a + g e_z + d_z (v - w)),      y_C = (-sin ψ, cos ψ, 0).

Faessler, Franchi, Scaramuzza 2018 (RA-L 3(2)), section III; without drag Mellinger and Kumar 2011 (ICRA). The rates are
the solution of the derivative of these equations, which is linear in them; the angular accelerations of the next.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from crosstrack.errors import InputError, Problem, reported_by
from crosstrack.protocols import Trajectory
from crosstrack.trajectory.flatness.yaw import EAST, Yaw
from crosstrack.types import GRAVITY, Array, Vector

SINGULAR = 1e-3
"""m/s², of the thrust across the axis that a yaw leaves open: with less, yaw does not fix the attitude"""
NOTHING: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class Flat:
    """What a quadrotor does along a trajectory, at n times."""

    time: Array
    """(n,) s"""
    attitude: Array
    """(n, 4) unit quaternions xyzw, body to world, without jumps of sign"""
    thrust: Array
    """(n,) m/s², collective thrust over mass, along body z"""
    rate: Array
    """(n, 3) rad/s, body"""
    angular_acceleration: Array
    """(n, 3) rad/s², body"""

    @property
    def tilt(self) -> Array:
        """(n,) rad, between body z and world z"""
        return np.asarray(2 * np.arcsin(np.minimum(1.0, np.hypot(self.attitude[:, 0], self.attitude[:, 1]))))


@reported_by("flatten")
def flatten(
    trajectory: Trajectory,
    times: Array,
    yaw: Yaw = EAST,
    drag: Vector = NOTHING,
    wind: Vector = NOTHING,
) -> Flat:
    """Return what a quadrotor must do to fly a trajectory.

    Args:
        trajectory: with four derivatives
        times: (n,) s
        yaw: by time, see `crosstrack.trajectory.flatness.yaw`
        drag: 1/s, rotor drag over mass and airspeed along each body axis
        wind: m/s, world, steady

    Raises:
        InputError: times or trajectory have another shape than that; or at some time the thrust vanishes, or points
            sideways so that yaw does not fix the attitude.
    """
    times = np.asarray(times, float)
    if times.ndim != 1 or trajectory(0.0).shape != (3,):
        shapes = f"found {trajectory(0.0).shape} at times {times.shape}"
        raise InputError("flatten", [Problem("trajectory", f"must be (3,) at times (n,), {shapes}")])
    velocity, acceleration, jerk, snap = (trajectory(times, order) for order in (1, 2, 3, 4))
    angle, spin, spin_up = (yaw(times, order) for order in (0, 1, 2))
    airspeed, force = velocity - np.array(wind), acceleration + np.array([0.0, 0.0, GRAVITY])
    none = np.zeros_like(angle)
    ahead = np.stack([np.cos(angle), np.sin(angle), none], axis=-1)
    across = np.stack([-ahead[:, 1], ahead[:, 0], none], axis=-1)
    frame = body_axes(times, across, force + drag[0] * airspeed, force + drag[1] * airspeed)
    u, f, a, j, s, ahead, across = (
        seen(frame, vector) for vector in (airspeed, force, acceleration, jerk, snap, ahead, across)
    )
    x, dx, ddx = (value + drag[0] * blow for value, blow in ((f, u), (j, a), (s, j)))
    y, dy, ddy = (value + drag[1] * blow for value, blow in ((f, u), (j, a), (s, j)))
    rate, angular = turned((x, dx, ddx), (y, dy, ddy), across, ahead, spin, spin_up)
    return Flat(times, quaternions(frame), f[:, 2] + drag[2] * u[:, 2], rate, angular)


def turned(
    x: tuple[Array, Array, Array],
    y: tuple[Array, Array, Array],
    across: Array,
    ahead: Array,
    spin: Array,
    spin_up: Array,
) -> tuple[Array, Array]:
    """Return body rates (n, 3) rad/s and angular accelerations (n, 3) rad/s² that keep x_x = y_y = across_x = 0.

    All vectors (n, 3) are in body axes, where the derivative of Rᵀb is Rᵀb' + Rᵀb × ω.

    Args:
        x: force that x_B is perpendicular to, and its first two derivatives
        y: likewise for y_B
        across: y_C
        ahead: x_C, so that x_C' = ψ' y_C and y_C' = -ψ' x_C
        spin: (n,) rad/s, ψ'
        spin_up: (n,) rad/s², ψ''
    """
    matrix = constraints(x[0], y[0], across)
    rate = solved(matrix, np.stack([x[1][:, 0], y[1][:, 1], spin * ahead[:, 0]], axis=-1))
    # The derivative of the same: matrix · ω' = (right side)' - matrix' · ω.
    jolt_x, jolt_y = x[2] + np.cross(x[1], rate), y[2] + np.cross(y[1], rate)
    sway = spin[:, None] * across + np.cross(ahead, rate)
    right = np.stack([jolt_x[:, 0], jolt_y[:, 1], spin_up * ahead[:, 0] + spin * sway[:, 0]], axis=-1)
    change = constraints(
        x[1] + np.cross(x[0], rate), y[1] + np.cross(y[0], rate), np.cross(across, rate) - spin[:, None] * ahead
    )
    return rate, solved(matrix, right - seen(change, rate))


def body_axes(times: Array, across: Array, for_x: Array, for_y: Array) -> Array:
    """Return the body axes in the world as the rows of matrices (n, 3, 3); `across` is y_C, the others see the module.

    Raises:
        InputError: the force that an axis is perpendicular to has nothing across the axis that is given.
    """
    x = np.cross(across, for_x)
    x_size = np.linalg.norm(x, axis=1)
    assure(times, x_size, for_x)
    x = x / x_size[:, None]
    y = np.cross(for_y, x)
    y_size = np.linalg.norm(y, axis=1)
    assure(times, y_size, for_y)
    y = y / y_size[:, None]
    return np.stack([x, y, np.cross(x, y)], axis=1)


def assure(times: Array, sizes: Array, force: Array) -> None:
    """Raise InputError at the first of the times (n,) s where a size (n,) m/s² is none, or not a number."""
    bad = np.flatnonzero(~(sizes > SINGULAR))
    if not bad.size:
        return
    k = bad[0]
    strength = float(np.linalg.norm(force[k]))
    if not np.isfinite(strength):
        why = "position, yaw or their derivatives are not finite"
    elif strength <= SINGULAR:
        why = f"free fall: the thrust is {strength:.2g} m/s², and without any the attitude is open"
    else:
        why = f"the thrust of {strength:.3g} m/s² points along the body's y axis at level: the yaw is open"
    raise InputError("trajectory", [Problem(f"t = {times[k]:.6g} s", why)])


def seen(matrix: Array, vector: Array) -> Array:
    """Return the products of matrices (n, 3, 3) and vectors (n, 3)."""
    return np.asarray((matrix @ vector[:, :, None])[:, :, 0])


def constraints(x: Array, y: Array, side: Array) -> Array:
    """Return the matrix (n, 3, 3) whose product with ω is -(x × ω)_x, -(y × ω)_y and (side × ω)_x."""
    matrix = np.zeros((len(x), 3, 3))
    matrix[:, 0, 1], matrix[:, 0, 2] = x[:, 2], -x[:, 1]
    matrix[:, 1, 0], matrix[:, 1, 2] = -y[:, 2], y[:, 0]
    matrix[:, 2, 1], matrix[:, 2, 2] = -side[:, 2], side[:, 1]
    return matrix


def solved(matrix: Array, right: Array) -> Array:
    """Return the solutions (n, 3) of linear systems (n, 3, 3) with right sides (n, 3)."""
    return np.asarray(np.linalg.solve(matrix, right[:, :, None])[:, :, 0])


def quaternions(frame: Array) -> Array:
    """Return body axes as rows (n, 3, 3) as quaternions xyzw (n, 4), each on the side of the one before."""
    attitude = Rotation.from_matrix(frame.transpose(0, 2, 1)).as_quat()
    near = np.einsum("ij,ij->i", attitude[1:], attitude[:-1]) >= 0
    signs = np.cumprod(np.concatenate([[1.0], np.where(near, 1.0, -1.0)]))
    return np.asarray(attitude * signs[:, None])

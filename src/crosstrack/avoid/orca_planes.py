"""Half-spaces of velocities that keep a vehicle clear of what moves: optimal reciprocal collision avoidance in 3-D.

Two balls at a distance p, with radii that add up to R, touch within a time τ exactly when their relative velocity lies
in the velocity obstacle: the cone of half-angle α, sin α = R / |p|, around p, cut off by the ball of radius R/τ around
p/τ. With u the shortest change of the relative velocity that takes it to the boundary, and n the normal there, one that
takes the share s of the change keeps to n·v >= n·(own + s u) (van den Berg, Guy, Lin, Manocha 2011).
"""

import math

from crosstrack.compiled import compiled

SMALL = 1e-9
REGAIN = 0.5
"""s, over which a margin is regained that was undercut"""

Plane = tuple[float, float, float, float]
"""unit normal, and the excess: how far (m/s) the relative velocity is outside the obstacle along it, negative inside"""


@compiled
def sideways(ex: float, ey: float, ez: float) -> tuple[float, float, float]:
    """Return the level unit vector to the right of a unit vector; south of one that points up, north of one down."""
    size = math.sqrt(ex * ex + ey * ey)
    if size < SMALL:
        return 0.0, -math.copysign(1.0, ez), 0.0
    return ey / size, -ex / size, 0.0


@compiled
def apart(px: float, py: float, pz: float, vx: float, vy: float, vz: float, radius: float, horizon: float) -> Plane:
    """Return where the relative velocity lies in respect to the velocity obstacle of a ball that is not touched.

    Of one that points straight at the ball the nearest boundary is on every side: it is taken to the right.

    p is the way to the ball (m), v the own velocity less that of the ball (m/s), `radius` the sum of the radii (m),
    below the distance, and `horizon` τ (s).
    """
    distance = math.sqrt(px * px + py * py + pz * pz)
    ex, ey, ez = px / distance, py / distance, pz / distance
    along = vx * ex + vy * ey + vz * ez
    wx, wy, wz = vx - px / horizon, vy - py / horizon, vz - pz / horizon
    size = math.sqrt(wx * wx + wy * wy + wz * wz)
    back = distance / horizon - along
    sine = radius / distance
    if back >= sine * size and size > SMALL:
        return wx / size, wy / size, wz / size, size - radius / horizon
    fx, fy, fz = vx - along * ex, vy - along * ey, vz - along * ez
    across = math.sqrt(fx * fx + fy * fy + fz * fz)
    if across > SMALL:
        fx, fy, fz = fx / across, fy / across, fz / across
    else:
        fx, fy, fz = sideways(ex, ey, ez)
        across = 0.0
    cosine = math.sqrt(1.0 - sine * sine)
    nx, ny, nz = cosine * fx - sine * ex, cosine * fy - sine * ey, cosine * fz - sine * ez
    return nx, ny, nz, cosine * across - sine * along


@compiled
def excess(
    px: float, py: float, pz: float, vx: float, vy: float, vz: float, touch: float, radius: float, horizon: float
) -> Plane:
    """Return the boundary of the velocity obstacle of a ball nearest to a relative velocity.

    Nearer than the radius, which holds a margin, the ball must go away, so that the margin is regained within REGAIN;
    where even the sum of the radii, `touch`, is undercut, four times as fast. For the others see `apart`.
    """
    distance = math.sqrt(px * px + py * py + pz * pz)
    if distance > radius:
        return apart(px, py, pz, vx, vy, vz, radius, horizon)
    if distance < SMALL:
        return 0.0, 1.0, 0.0, vy - 4 * radius / REGAIN
    nx, ny, nz = -px / distance, -py / distance, -pz / distance
    pace = (radius - distance + 3 * max(0.0, touch - distance)) / REGAIN
    return nx, ny, nz, vx * nx + vy * ny + vz * nz - pace

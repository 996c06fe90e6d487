"""The certified maximum of one polynomial.

It is searched by branch and bound on the Bernstein form. The interval is halved until, on every part of it, one of

- the convex hull: no value is above the largest coefficient,
- the slope: f' lies between n times the least and the largest difference of neighbouring coefficients,
- the tangent, where the second differences show that f is concave: f(u) <= f(û) + f'(û) (u - û)

shows that the part holds nothing above the best value found by more than the tolerance. What the arithmetic may have
rounded away is added to every bound.
"""

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.trajectory.certified.bernstein import DEEPEST, EPSILON, differences, divide
from crosstrack.types import Array


@compiled
def peak(control: Array, floor: float, absolute: float, relative: float, stack: Array) -> tuple[float, float, float]:
    """Enclose the maximum over u in [0, 1] of the polynomial with Bernstein coefficients `control`.

    Args:
        control: (degree + 1,)
        floor: what is not above it need not be told apart: only that it is not above is shown; -inf for nothing
        absolute: tolerance
        relative: tolerance, of the largest value
        stack: (DEEPEST + 2, degree + 3), to work in

    Returns:
        bound, value, u: nothing is above `bound`, the value at u is `value`, and the bound is at most
        max(value, floor) + absolute + relative |max(value, floor)|, or what rounding adds. Infinite bound where a
        coefficient is not finite.
    """
    degree = control.size - 1
    scale, total = 0.0, 0.0
    for i in range(degree + 1):
        scale = max(scale, abs(control[i]))
        total += abs(control[i])
        stack[0, i] = control[i]
    low, at = control[0], 0.0
    if not total < np.inf:
        return np.inf, low, at
    if control[degree] > low:
        low, at = control[degree], 1.0
    noise = EPSILON * (DEEPEST + 4 * degree) * (degree + 1) * scale
    bound = low
    stack[0, degree + 1], stack[0, degree + 2] = 0.0, 1.0
    top = 0
    while top >= 0:
        part = stack[top]
        start, width = part[degree + 1], part[degree + 2]
        best = max(low, floor)
        threshold = best + max(absolute + relative * abs(best), noise)
        reach, bend = ceiling(part, degree)
        if reach > threshold and bend <= noise:
            crown, value, u = crest(part, degree, bend, 0.25 * (threshold - best))
            if value > low:
                low, at = value, start + u * width
                threshold += max(low - best, 0.0)
            reach = min(reach, crown)
        if reach <= threshold or width < EPSILON:
            bound = max(bound, reach)
            top -= 1
            continue
        right = stack[top + 1]
        divide(part, right, degree + 1, 0.5)
        part[degree + 2] = right[degree + 2] = 0.5 * width
        right[degree + 1] = start + 0.5 * width
        if right[0] > low:
            low, at = right[0], right[degree + 1]
        if part[0] > right[degree]:  # the half with the higher end first
            for i in range(degree + 3):
                part[i], right[i] = right[i], part[i]
        top += 1
    return bound + noise, low, at


@compiled
def ceiling(control: Array, degree: int) -> tuple[float, float]:
    """Return a bound on the values by hull and slopes, and the largest second difference of the coefficients."""
    top, bend = control[0], -np.inf
    least, most = 0.0, 0.0
    before = 0.0
    for i in range(1, degree + 1):
        top = max(top, control[i])
        step = control[i] - control[i - 1]
        least, most = min(least, step), max(most, step)
        if i > 1:
            bend = max(bend, step - before)
        before = step
    return min(top, control[degree] - degree * least, control[0] + degree * most), bend


@compiled
def crest(control: Array, degree: int, bend: float, enough: float) -> tuple[float, float, float]:
    """Find the top of a concave polynomial by safeguarded Newton steps, and bound it by the tangent there.

    Args:
        control: (degree + 1,)
        degree: at least 1
        bend: largest second difference; what is above zero loosens the bound
        enough: slope at which the top is found

    Returns:
        bound, value, u
    """
    left, right = 0.0, 1.0
    first, last = control[1] - control[0], control[degree] - control[degree - 1]
    u = first / (first - last) if first > 0.0 > last else 0.5
    slope = 0.0
    for _ in range(20):
        slope = degree * differences(control, degree, 1, u)
        if abs(slope) <= enough:
            break
        left, right = (u, right) if slope > 0.0 else (left, u)
        curvature = degree * (degree - 1) * differences(control, degree, 2, u)
        step = u - slope / curvature if curvature < 0.0 else left
        u = step if left < step < right else 0.5 * (left + right)
    slope = degree * differences(control, degree, 1, u)
    value = differences(control, degree, 0, u)
    loose = 0.5 * degree * (degree - 1) * max(bend, 0.0)
    return value + max(slope * (1.0 - u), -slope * u) + loose, value, u

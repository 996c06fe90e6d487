"""Trajectories: piecewise polynomials by time, how to make them, and what can be proven of them."""

from typing import TYPE_CHECKING

from crosstrack.lazy import lazily

if TYPE_CHECKING:
    from crosstrack.trajectory.batch import minimum_batch as minimum_batch
    from crosstrack.trajectory.certified.certificate import Certificate as Certificate
    from crosstrack.trajectory.certified.certificate import certify as certify
    from crosstrack.trajectory.certified.clearance import least_clearance as least_clearance
    from crosstrack.trajectory.certified.extremes import axis_range as axis_range
    from crosstrack.trajectory.certified.extremes import largest_norm as largest_norm
    from crosstrack.trajectory.certified.polyline_distance import largest_deviation as largest_deviation
    from crosstrack.trajectory.constrained.bounded import Solution as Solution
    from crosstrack.trajectory.constrained.bounded import solve as solve
    from crosstrack.trajectory.constrained.corridor import Boxes as Boxes
    from crosstrack.trajectory.constrained.corridor import Polytopes as Polytopes
    from crosstrack.trajectory.constrained.corridor import Tube as Tube
    from crosstrack.trajectory.constrained.corridor import subdivide as subdivide
    from crosstrack.trajectory.flatness.ability import Ability as Ability
    from crosstrack.trajectory.flatness.ability import demands as demands
    from crosstrack.trajectory.flatness.flat import flatten as flatten
    from crosstrack.trajectory.flatness.yaw import Faced as Faced
    from crosstrack.trajectory.flatness.yaw import Fixed as Fixed
    from crosstrack.trajectory.flatness.yaw import along_velocity as along_velocity
    from crosstrack.trajectory.flatness.yaw import towards as towards
    from crosstrack.trajectory.guide import Guide as Guide
    from crosstrack.trajectory.guide import chord as chord
    from crosstrack.trajectory.limits import MotionLimits as MotionLimits
    from crosstrack.trajectory.minimum_derivative import minimum as minimum
    from crosstrack.trajectory.polynomial import PiecewisePolynomial as PiecewisePolynomial
    from crosstrack.trajectory.target import Pursuit as Pursuit
    from crosstrack.trajectory.target import TargetPlan as TargetPlan
    from crosstrack.trajectory.target import track_target as track_target
    from crosstrack.trajectory.times.fastest import fastest as fastest
    from crosstrack.trajectory.times.optimal import least_effort as least_effort
    from crosstrack.trajectory.times.optimal import least_effort_and_time as least_effort_and_time
    from crosstrack.trajectory.times.timing import constant_speed as constant_speed
    from crosstrack.trajectory.times.timing import rescaled as rescaled
    from crosstrack.trajectory.times.timing import square_root as square_root
    from crosstrack.trajectory.times.timing import trapezoid as trapezoid
    from crosstrack.trajectory.weights.choose import choose_weights as choose_weights
    from crosstrack.trajectory.weights.study import study as study

_PUBLIC = {
    "Ability": "flatness.ability",
    "Boxes": "constrained.corridor",
    "Certificate": "certified.certificate",
    "Faced": "flatness.yaw",
    "Fixed": "flatness.yaw",
    "Guide": "guide",
    "MotionLimits": "limits",
    "PiecewisePolynomial": "polynomial",
    "Polytopes": "constrained.corridor",
    "Pursuit": "target",
    "Solution": "constrained.bounded",
    "TargetPlan": "target",
    "Tube": "constrained.corridor",
    "along_velocity": "flatness.yaw",
    "axis_range": "certified.extremes",
    "certify": "certified.certificate",
    "choose_weights": "weights.choose",
    "chord": "guide",
    "constant_speed": "times.timing",
    "demands": "flatness.ability",
    "fastest": "times.fastest",
    "flatten": "flatness.flat",
    "largest_deviation": "certified.polyline_distance",
    "largest_norm": "certified.extremes",
    "least_clearance": "certified.clearance",
    "least_effort": "times.optimal",
    "least_effort_and_time": "times.optimal",
    "minimum": "minimum_derivative",
    "minimum_batch": "batch",
    "rescaled": "times.timing",
    "solve": "constrained.bounded",
    "square_root": "times.timing",
    "study": "weights.study",
    "subdivide": "constrained.corridor",
    "towards": "flatness.yaw",
    "track_target": "target",
    "trapezoid": "times.timing",
}

__all__ = [*_PUBLIC]  # noqa: PLE0604 - the names are the table's

__getattr__, __dir__ = lazily(__name__, _PUBLIC)

"""How metrics are called and written for people."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

LABELS: dict[str, tuple[str, str, str]] = {
    "flight_time_s": ("Flight time", "s", ".2f"),
    "ideal_time_s": ("Planned time", "s", ".2f"),
    "time_ratio": ("Flight time over planned time", "", ".3f"),
    "cross_track_rms_m": ("Cross-track error, RMS", "m", ".3f"),
    "cross_track_max_m": ("Largest cross-track error", "m", ".3f"),
    "cross_track_rms_captured_m": ("Cross-track error, RMS once captured", "m", ".3f"),
    "cross_track_max_captured_m": ("Largest cross-track error once captured", "m", ".3f"),
    "captured_time_s": ("Captured (error under 0.05 m) after", "s", ".2f"),
    "tracking_rms_m": ("Distance to the trajectory's point, RMS", "m", ".3f"),
    "tracking_max_m": ("Largest distance to the trajectory's point", "m", ".3f"),
    "final_error_m": ("Distance to the last waypoint", "m", ".3f"),
    "final_speed_mps": ("Speed at the end", "m/s", ".3f"),
    "min_clearance_m": ("Least clearance", "m", ".3f"),
    "min_separation_m": ("Least distance to another vehicle's centre", "m", ".3f"),
    "path_length_m": ("Length of the route", "m", ".2f"),
    "flown_length_m": ("Length flown", "m", ".2f"),
    "max_speed_mps": ("Top speed", "m/s", ".2f"),
    "mean_speed_mps": ("Mean speed", "m/s", ".2f"),
    "max_airspeed_mps": ("Top airspeed", "m/s", ".2f"),
    "max_acceleration_mps2": ("Largest acceleration between samples", "m/s²", ".2f"),
    "rms_jerk_mps3": ("Jerk between samples, RMS", "m/s³", ".2f"),
    "max_tilt_deg": ("Largest tilt", "°", ".1f"),
    "control_effort_radps": ("Rotor speeds about their means, RMS", "rad/s", ".1f"),
    "replans": ("Courses planned in flight", "", "d"),
    "safety_interventions": ("Times that a safety layer stepped in", "", "d"),
    "planning_time_s": ("Time to plan", "s", ".3f"),
    "decision_time_s": ("Time of one decision, median", "s", ".5f"),
    "decision_time_p99_s": ("Time of one decision, 99th percentile", "s", ".5f"),
    "wall_time_s": ("Time to compute", "s", ".2f"),
}
"""metric to its label, unit and number format"""

CARDS = (
    "flight_time_s",
    "cross_track_rms_m",
    "cross_track_max_m",
    "tracking_rms_m",
    "final_error_m",
    "max_speed_mps",
    "min_clearance_m",
)
"""the metrics that head a report"""

AVOIDING_CARDS = ("replans", "safety_interventions")
"""more of them, where there are avoiders"""

CHASED = {False: "carrot", True: "aim"}
"""what the point chased is called, without and with a trajectory"""

NOTHING = "\N{EN DASH}"


@dataclass(frozen=True)
class Row:
    """One metric of some flights, written out."""

    label: str
    unit: str
    values: tuple[str, ...]


def rows(summaries: Sequence[dict[str, Any]], names: Sequence[str] = tuple(LABELS)) -> list[Row]:
    """Return metrics of some flights as texts, a dash where there is nothing to measure."""
    return [
        Row(label, unit, tuple(number(summary[name], style) for summary in summaries))
        for name in names
        for label, unit, style in [LABELS[name]]
    ]


def number(value: float | None, style: str) -> str:
    """Write a number in a format, a dash for None."""
    return NOTHING if value is None else format(value, style)

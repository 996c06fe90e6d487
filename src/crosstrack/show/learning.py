"""The learning curve of a training, as a picture."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

SHARES = {"success": "#1a7f37", "collided": "#cf222e", "left_bounds": "#9a6700", "timed_out": "#6e7781"}
"""colour of each outcome"""


def learning_curve(history: Sequence[Mapping[str, Any]], path: str | Path, title: str) -> None:
    """Draw how episodes in worlds held out ended, and the mean reward, by decisions and minutes of training."""
    figure = Figure(figsize=(8, 5.5), layout="constrained")
    FigureCanvasAgg(figure)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=[2, 1])
    steps = [row["steps"] / 1e6 for row in history]
    for name, color in SHARES.items():
        above.plot(steps, [100 * row[name] for row in history], ".-", color=color, label=name.replace("_", " "))
    above.set_ylabel("episodes, %")
    above.set_ylim(-2, 102)
    above.legend(loc="center right")
    above.set_title(f"{title}: {history[-1]['episodes']} worlds that training does not see")
    below.plot(steps, [row["reward"] for row in history], ".-", color="#0969da")
    below.set_ylabel("mean reward")
    below.set_xlabel("decisions, millions")
    for axes in (above, below):
        axes.grid(alpha=0.3)
    minutes = above.secondary_xaxis("top", functions=scales(steps, [row["seconds"] / 60 for row in history]))
    minutes.set_xlabel("minutes")
    above.set_title(above.get_title(), pad=34)
    figure.savefig(path, dpi=110)


def scales(steps: Sequence[float], minutes: Sequence[float]) -> tuple[Any, Any]:
    """Return what turns millions of decisions into minutes, and back, at the mean rate."""
    rate = minutes[-1] / steps[-1] if steps[-1] > 0 and minutes[-1] > 0 else 1.0
    return (lambda value: value * rate), (lambda value: value / rate)

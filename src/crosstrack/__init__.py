"""Fly quadrotor missions: plan, smooth, track, avoid, show.

The public names below are imported on first use, so that `import crosstrack` costs next to nothing.
"""

from typing import TYPE_CHECKING

from crosstrack.lazy import lazily

__version__ = "0.1.0"

if TYPE_CHECKING:
    from crosstrack.campaign.compare import compare as compare
    from crosstrack.errors import CrosstrackError as CrosstrackError
    from crosstrack.errors import Infeasible as Infeasible
    from crosstrack.errors import InputError as InputError
    from crosstrack.flight.flight import Flight as Flight
    from crosstrack.flight.plan import Plan as Plan
    from crosstrack.mission.certified import certified as certified
    from crosstrack.mission.flying import fly as fly
    from crosstrack.mission.load import from_document as from_document
    from crosstrack.mission.load import load as load
    from crosstrack.mission.load import loads as loads
    from crosstrack.mission.load import save as save
    from crosstrack.mission.mission import Mission as Mission
    from crosstrack.mission.schema import Start as Start
    from crosstrack.show.pictures import pictures as pictures
    from crosstrack.show.plan_page import plan_page as plan_page
    from crosstrack.show.report import report as report
    from crosstrack.types import Outcome as Outcome

_PUBLIC = {
    "CrosstrackError": "errors",
    "Flight": "flight.flight",
    "Infeasible": "errors",
    "InputError": "errors",
    "Mission": "mission.mission",
    "Outcome": "types",
    "Plan": "flight.plan",
    "Start": "mission.schema",
    "certified": "mission.certified",
    "compare": "campaign.compare",
    "fly": "mission.flying",
    "fly_together": "mission.flying",
    "from_document": "mission.load",
    "load": "mission.load",
    "loads": "mission.load",
    "pictures": "show.pictures",
    "plan_page": "show.plan_page",
    "report": "show.report",
    "save": "mission.load",
}

__all__ = ["__version__", *_PUBLIC]  # noqa: PLE0604 - the names are the table's


__getattr__, __dir__ = lazily(__name__, _PUBLIC)

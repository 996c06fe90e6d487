"""The mission file: its schema, reading and writing it, and making a plan of it."""

from crosstrack.mission.document import schema
from crosstrack.mission.export import export_plan
from crosstrack.mission.load import from_document, load, loads, save
from crosstrack.mission.mission import Mission
from crosstrack.mission.schema import Start, Timing

__all__ = [
    "Mission",
    "Start",
    "Timing",
    "export_plan",
    "from_document",
    "load",
    "loads",
    "save",
    "schema",
]

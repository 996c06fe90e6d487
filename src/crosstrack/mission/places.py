"""What a mission's schema has at a place."""

from dataclasses import fields, is_dataclass
from typing import Any, get_args

from crosstrack.mission.document import hints, role_of
from crosstrack.mission.parts import part_class
from crosstrack.mission.schema import MissionFile
from crosstrack.mission.text import Document, Place


def schema_at(place: Place, document: Any) -> tuple[type[Any] | None, str | None]:
    """Return the dataclass whose fields a place holds, and its role where it is a registered part.

    None where the place holds no fields, or names no registered part.
    """
    cls: Any = MissionFile
    role, hint = None, None
    for part in place:
        if isinstance(part, str):
            hint = hints(cls)[part] if cls and part in hints(cls) else None
            role = role_of(hint)
            document = document.get(part) if isinstance(document, dict) else None
        else:
            document = document[part] if isinstance(document, list) else None
        cls = part_class(role, document) if role else _dataclass(hint)
    return cls, role


def known_fields(place: Place, document: Any) -> list[str]:
    """Return the field names that a place may hold; none where it holds no fields."""
    cls, role = schema_at(place, document)
    return (["kind"] if role else []) + ([field.name for field in fields(cls)] if cls else [])


def line_of(place: Place, document: Document) -> int | None:
    """Return the line of a place, or of what encloses it; None where it was set from outside the file."""
    for end in range(len(place), 0, -1):
        if place[:end] in document.lines:
            return document.lines[place[:end]] or None
    return None


def _dataclass(hint: Any) -> Any:
    """Return the dataclass that a field holds, alone, optional or in a tuple; None where it holds none."""
    if isinstance(hint, type) and is_dataclass(hint):
        return hint
    return next((found for found in map(_dataclass, get_args(hint)) if found), None)

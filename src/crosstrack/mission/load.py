"""Reading and writing missions."""

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from crosstrack.errors import InputError, Problem
from crosstrack.frames import Origin, ned_from_enu
from crosstrack.mission.check import faults
from crosstrack.mission.complaints import faults_of
from crosstrack.mission.document import mission_adapter
from crosstrack.mission.mission import Mission
from crosstrack.mission.overrides import override
from crosstrack.mission.parts import adapter
from crosstrack.mission.places import line_of
from crosstrack.mission.qgroundcontrol import read_plan
from crosstrack.mission.text import Document, parse, read_text, scalar, show
from crosstrack.mission.values import sound
from crosstrack.world.files import Files, read

PLACEHOLDERS = {"start": {"position": [0, 0, 0]}}
"""stand in for a required field that is broken, while the rest is checked"""


def load(path: str | Path, settings: Sequence[str] = ()) -> Mission:
    """Read a mission file.

    Args:
        path: a YAML or JSON file; the files that it names lie relative to its folder
        settings: changes such as `tracker.lookahead=2`, applied before the mission is checked

    Raises:
        InputError: everything that is wrong with it, each with its place and line.
    """
    path = Path(path)
    text = read_text(path)
    if path.suffix.lower() == ".plan":
        message = f"is a route, not a mission: name it in a mission file, as `route: {path.name}`"
        raise InputError(str(path), [Problem("", message)])
    document = parse(text, str(path))
    if isinstance(document.value, dict):
        document.value.setdefault("name", path.stem)
    return validated(document, path.parent, settings)


def loads(text: str, folder: str | Path = ".", settings: Sequence[str] = ()) -> Mission:
    """Read a mission from text; the files that it names lie relative to a folder.

    Raises:
        InputError: everything that is wrong with it, each with its place and line.

    Example:
        >>> import crosstrack as ct
        >>> mission = ct.loads("{start: {position: [0, 0, 10]}, route: [[20, 0]], speed: 3}")
        >>> mission.tracker.lookahead, mission.points.tolist()
        (1.0, [[0.0, 0.0, 10.0], [20.0, 0.0, 10.0]])
    """
    return validated(parse(text, "mission"), Path(folder), settings)


def save(mission: Mission, path: str | Path) -> None:
    """Write a mission as YAML, defaults included; loading it from the same folder gives an equal mission.

    Raises:
        OSError: the file cannot be written.
    """
    Path(path).write_text(dump(mission.document()), encoding="utf-8")


def dump(document: Mapping[str, Any]) -> str:
    """Write a document as YAML."""
    return yaml.dump(dict(document), Dumper=_Dumper, sort_keys=False, allow_unicode=True, width=110)


def from_document(document: Mapping[str, Any], files: Files = Path()) -> Mission:
    """Make a mission of plain values, such as `{"start": {"position": [0, 0, 10]}, "route": [[20, 0]]}`.

    Args:
        document: what a mission file would say
        files: the folder that names of files start from, or their contents by name, as a log keeps them

    Raises:
        InputError: everything that is wrong with them, each with its place.

    Example:
        >>> import crosstrack as ct
        >>> ct.from_document({"start": {"position": [0, 0, 10]}, "route": [[20, 0]]}).speed
        5.0
    """
    unsound: list[Problem] = []
    value = sound(dict(document), unsound)
    if unsound:
        raise InputError("mission", unsound)
    return validated(Document("mission", value), files)


def validated(document: Document, files: Files, settings: Sequence[str] = ()) -> Mission:
    """Return the mission that a document says, with settings applied, once all of it is found right."""
    if not isinstance(document.value, dict):
        raise InputError(document.source, [Problem("", "must be a mapping of names to values, such as `speed: 5`")])
    document = completed(override(document, settings), files)
    found = faults_of(document)
    broken = {re.split(r"[.\[]", problem.place)[0] for problem in found}
    value = {name: kept for name, kept in document.value.items() if name not in broken}
    value = {**PLACEHOLDERS, **value} if broken else value
    checked = mission_adapter().validate_json(json.dumps(value))
    mission = Mission(**{f.name: getattr(checked, f.name) for f in fields(checked)}, files=files)
    found += [Problem(show(place), message, line_of(place, document)) for place, message in faults(mission, broken)]
    if found:
        raise InputError(document.source, sorted(found, key=lambda problem: problem.line or 0))
    return mission


def completed(document: Document, files: Files) -> Document:
    """Return a document with what its `.plan` file says of start and speed, where it says nothing itself."""
    value, first = document.value, first_of(document.value.get("vehicles"))
    if first:
        value = {name: first[name] for name in ("start",) if name in first} | value
        document = replace(document, value=value)
    route = value.get("route")
    if not isinstance(route, str) or {"start", "speed"} <= value.keys():
        return document
    try:
        origin = adapter(Origin).validate_json(json.dumps(value.get("origin")))
        plan = read_plan(route, read(files, route), origin)
    except (InputError, ValidationError):  # told, with all else, when the route and the origin are checked
        return document
    first = plan.points[0]
    position = (ned_from_enu(first) if value.get("frame") == "ned" else first).tolist()
    speed = {} if plan.speed is None else {"speed": plan.speed}
    return replace(document, value={"start": {"position": position, "takeoff": plan.takeoff}, **speed, **value})


def first_of(vehicles: Any) -> dict[str, Any]:
    """Return what the first of several vehicles says, as far as that can be read."""
    first = vehicles[0] if isinstance(vehicles, list) and vehicles else None
    return first if isinstance(first, dict) else {}


class _Dumper(yaml.SafeDumper):
    """Write short lists on one line."""


def _list(dumper: yaml.SafeDumper, value: list[Any]) -> yaml.Node:
    numbers = all(isinstance(item, int | float) for item in value)
    return dumper.represent_sequence("tag:yaml.org,2002:seq", value, flow_style=numbers)


def _text(dumper: yaml.SafeDumper, value: str) -> yaml.Node:
    """Quote text that would be read as something else."""
    quoted = "'" if not isinstance(scalar(value), str) else None
    return dumper.represent_scalar("tag:yaml.org,2002:str", value, style=quoted)


_Dumper.add_representer(list, _list)
_Dumper.add_representer(str, _text)

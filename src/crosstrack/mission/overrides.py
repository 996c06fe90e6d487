"""Changes to a mission's document from outside the file: `tracker.lookahead=2`."""

import copy
from collections.abc import Sequence
from dataclasses import MISSING, fields
from typing import Any

from crosstrack import registry
from crosstrack.errors import InputError, Problem
from crosstrack.mission.document import hints, plain, role_of
from crosstrack.mission.parts import suggest
from crosstrack.mission.places import known_fields, schema_at
from crosstrack.mission.schema import MissionFile, usual_tracker
from crosstrack.mission.text import Document, parse


def override(document: Document, settings: Sequence[str]) -> Document:
    """Return a document with `PATH=VALUE` settings applied in order; values are YAML.

    Setting the `kind` of a part keeps those of its other fields that the new kind has too.

    Raises:
        InputError: a setting that is not `PATH=VALUE`, or a path that a mission does not have.
    """
    value = copy.deepcopy(document.value)
    lines = dict(document.lines)
    problems: list[Problem] = []
    for setting in settings:
        path, equals, text = setting.partition("=")
        if not equals:
            problems.append(Problem(setting, "must be PATH=VALUE, such as tracker.lookahead=2"))
            continue
        try:
            place = assign(value, path.strip(), parse(text, path).value)
            lines = {known: line for known, line in lines.items() if known[: len(place)] != place} | {place: 0}
        except InputError as error:
            problems += error.problems
    if problems:
        raise InputError("setting", problems)
    return Document(document.source, value, lines)


def assign(document: Any, path: str, value: Any) -> tuple[str | int, ...]:
    """Set one value in a document, and return its place."""
    place: tuple[str | int, ...] = ()
    *outer, last = path.split(".")
    target = document
    for name in outer:
        key = _key(document, place, target, name, path)
        if isinstance(target, dict) and target.get(key) is None:
            target[key] = _default(document, place, key)
        target = target[key]
        place = (*place, key)
    key = _key(document, place, target, last, path)
    if key == "kind" and place:
        _change_kind(document, place, target, value)
    target[key] = value
    return (*place, key)


def _key(document: Any, place: tuple[str | int, ...], target: Any, name: str, path: str) -> Any:
    """Return the key or index that a name stands for."""
    if isinstance(target, list):
        if name.isdecimal() and int(name) < len(target):
            return int(name)
        raise InputError("", [Problem(path, f"{name!r} is no index of a list of {len(target)}, counted from 0")])
    known = known_fields(place, document) if isinstance(target, dict) else []
    if name not in known:
        raise InputError("", [Problem(path, f"there is no {name!r} here; {suggest(name, known)}")])
    return name


def _default(document: Any, place: tuple[str | int, ...], key: str) -> Any:
    """Return what to begin with where a document leaves a mapping out: a part needs its kind."""
    if (*place, key) == ("tracker",):
        return {"kind": usual_tracker(document.get("planner"))}
    field = next((f for f in fields(MissionFile) if f.name == key), None) if not place else None
    if field is None or field.default_factory is MISSING:
        return {}
    role = role_of(hints(MissionFile)[key])
    return {"kind": plain(field.default_factory(), role)["kind"]} if role else {}


def _change_kind(document: Any, place: tuple[str | int, ...], target: dict[str, Any], kind: Any) -> None:
    """Drop what a new kind of part has no field for."""
    _, role = schema_at(place, document)
    if role and kind in registry.names(role):
        known = {field.name for field in fields(registry.find(role, kind))}
        for name in [name for name in target if name not in known]:
            del target[name]

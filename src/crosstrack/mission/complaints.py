"""Validation errors said in the words of this library."""

import json
import math
from typing import Any

from pydantic_core import ErrorDetails, ValidationError

from crosstrack.errors import Problem
from crosstrack.mission.document import mission_adapter
from crosstrack.mission.parts import suggest
from crosstrack.mission.places import known_fields, line_of
from crosstrack.mission.text import Document, Place, show
from crosstrack.mission.values import LARGEST, tamed

WANTED = {
    "greater_than": "must be greater than {gt:g}",
    "greater_than_equal": "must be at least {ge:g}",
    "less_than": "must be less than {lt:g}",
    "less_than_equal": "must be at most {le:g}",
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "int_from_float": "must be a whole number",
    "bool_type": "must be true or false",
    "string_type": "must be text",
    "literal_error": "must be {expected}",
    "tuple_type": "must be a list",
    "dataclass_type": "must be a mapping of names to values",
}


def faults_of(document: Document) -> list[Problem]:
    """Return everything in which a document breaks the schema of missions."""
    extremes: dict[Place, float] = {}
    value = tamed(document.value, extremes)
    wanted = f"must be between -{LARGEST:g} and {LARGEST:g}, found"
    found = {p: Problem(show(p), f"{wanted} {size:g}", line_of(p, document)) for p, size in extremes.items()}
    try:
        mission_adapter().validate_json(json.dumps(value))
    except ValidationError as error:
        found = problems(error, document) | found
    return sorted(found.values(), key=lambda problem: problem.line or 0)


def problems(error: ValidationError, document: Document) -> dict[Place, Problem]:
    """Return what pydantic found by its place."""
    found: dict[Place, Problem] = {}
    for detail in error.errors(include_url=False):
        place = _place(detail, document.value)
        if _is_echo(detail):
            continue
        message = _message(detail, place, document.value)
        if place in found:
            message = _either(found[place].message, message)
        found[place] = Problem(show(place), message, line_of(place, document))
    return found


def _either(first: str, second: str) -> str:
    """Return one message for a value that two alternatives refuse: what either of them wants."""
    (wanted, comma, value), (other, _, same) = first.rpartition(", found "), second.rpartition(", found ")
    if value != same or not wanted.startswith("must be ") or not other.startswith("must be "):
        return first
    return f"{wanted} or {other.removeprefix('must be ')}{comma}{value}"


def _is_echo(detail: ErrorDetails) -> bool:
    """Return whether a list counts as too short only because of the wrong items in it, which are told themselves."""
    found = detail["input"]
    return detail["type"] == "too_short" and len(found) >= detail["ctx"]["min_length"]


def _place(detail: ErrorDetails, value: Any) -> Place:
    """Return where in the document an error is: pydantic's location without the tags of its unions."""
    place: list[str | int] = []
    for part in detail["loc"]:
        if _holds(value, part):
            place.append(part)
            value = value[part]
    if detail["type"] == "missing":
        place.append(detail["loc"][-1])
    return tuple(place)


def _holds(value: Any, part: str | int) -> bool:
    return (isinstance(value, dict) and part in value) or (isinstance(value, list) and part in range(len(value)))


def _message(detail: ErrorDetails, place: Place, document: Any) -> str:
    kind, context = detail["type"], detail.get("ctx", {})
    if kind == "missing":
        return "is missing from the list" if isinstance(place[-1], int) else "is required"
    if kind == "unexpected_keyword_argument":
        return f"unknown; {suggest(str(place[-1]), known_fields(place[:-1], document))}"
    if kind == "part":
        return str(context["message"])
    if kind == "value_error":
        return str(context["error"])
    if kind in {"too_short", "too_long"}:
        return _length(context)
    if math.inf in {context.get("lt"), -context.get("gt", 0.0)}:
        return f"must be a finite number, found {_found(detail['input'])}"
    wanted = WANTED[kind].format(**context) if kind in WANTED else detail["msg"]
    return f"{wanted}, found {_found(detail['input'])}"


def _length(context: dict[str, Any]) -> str:
    low, high = context.get("min_length"), context.get("max_length")
    bound = f"at least {low}" if low is not None else f"at most {high}"
    values = "value" if 1 in {low, high} else "values"
    return f"must hold {bound} {values}, found {context['actual_length']}"


def _found(value: Any) -> str:
    if isinstance(value, dict | list):
        return "a mapping" if isinstance(value, dict) else f"a list of {len(value)}"
    if value is None or isinstance(value, bool):
        return {None: "nothing", True: "true", False: "false"}[value]
    text = repr(value)
    return text if len(text) < 60 else f"{text[:57]}..."

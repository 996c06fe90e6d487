"""A mission as plain values, and the schema of those values."""

from dataclasses import fields, is_dataclass
from functools import cache
from typing import Annotated, Any, get_args, get_origin, get_type_hints

from pydantic import TypeAdapter

from crosstrack.mission.parts import Part, kind_of
from crosstrack.mission.schema import MissionFile


@cache
def mission_adapter() -> TypeAdapter[MissionFile]:
    """Return the validator of mission files."""
    return TypeAdapter(MissionFile)


@cache
def hints(cls: type[Any]) -> dict[str, Any]:
    """Return the field types of a dataclass, annotations kept."""
    return get_type_hints(cls, include_extras=True)


def role_of(hint: Any) -> str | None:
    """Return the role of the registered part that a field holds, alone or in a tuple, or None."""
    if get_origin(hint) is Annotated:
        role = next((mark.role for mark in hint.__metadata__ if isinstance(mark, Part)), None)
        return role or role_of(hint.__origin__)
    return next((role for role in map(role_of, get_args(hint)) if role), None)


def plain(value: Any, role: str | None = None) -> Any:
    """Return a mission, or anything in one, as plain values; fields that are None are left out."""
    if is_dataclass(value) and not isinstance(value, type):
        kind = {"kind": kind_of(role, value)} if role else {}
        types = hints(type(value))
        inner = {f.name: plain(getattr(value, f.name), role_of(types[f.name])) for f in fields(value)}
        return kind | {name: found for name, found in inner.items() if found is not None}
    if isinstance(value, tuple | list):
        return [plain(item, role) for item in value]
    return value


def schema() -> dict[str, Any]:
    """Return the JSON Schema (draft 2020-12) of mission files."""
    described = mission_adapter().json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **described}

"""Fields of a mission that name a registered part: `{kind: NAME, ...its fields}`."""

import ast
import difflib
import inspect
import json
import textwrap
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from itertools import pairwise
from typing import Any, Union

from pydantic import ConfigDict, GetCoreSchemaHandler, GetJsonSchemaHandler, TypeAdapter, ValidationError
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, InitErrorDetails, PydanticCustomError, core_schema

from crosstrack import registry
from crosstrack.errors import InputError, Problem
from crosstrack.protocols import FromFiles

CONFIG = ConfigDict(extra="forbid", strict=True, use_attribute_docstrings=True)


@cache
def adapter(part: Any) -> TypeAdapter[Any]:
    """Return the validator of a plain dataclass; unknown fields and text for numbers are errors."""
    # pydantic takes no configuration for a bare dataclass, but passes that of an optional one on
    return TypeAdapter(Union[part, None], config=CONFIG)  # noqa: UP007 - a value, not a type


@cache
def documented(part: type[Any]) -> dict[str, str]:
    """Return the docstrings under the fields of a class, inherited ones too, which pydantic leaves out."""
    found: dict[str, str] = {}
    for cls in reversed(part.__mro__[:-1]):
        body = ast.parse(textwrap.dedent(inspect.getsource(cls))).body[0]
        for field, text in pairwise(getattr(body, "body", [])):
            if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and isinstance(text, ast.Expr):
                found[field.target.id] = str(ast.literal_eval(text.value))
    return found


def kind_of(role: str, part: object) -> str:
    """Return the registered name of a part's class."""
    for name in registry.names(role):
        if registry.find(role, name) is type(part):
            return name
    raise InputError(role, [Problem("kind", f"{type(part).__qualname__} is not registered as a {role}")])


def given(part: Any, files: Mapping[str, bytes]) -> Any:
    """Return a part with the files that it reads, if any.

    Raises:
        InputError: a file cannot be used.
    """
    return part.given(files) if isinstance(part, FromFiles) else part


def suggest(word: str, known: list[str]) -> str:
    """Return what to say after an unknown word: the nearest known one, and all of them."""
    near = difflib.get_close_matches(word, known, 1)
    return (f"did you mean {near[0]!r}? " if near else "") + f"known: {', '.join(known) or 'none'}"


def part_class(role: str, value: object) -> type[Any] | None:
    """Return the class that `{kind: ...}` names, None where it names none."""
    kind = value.get("kind") if isinstance(value, Mapping) else None
    return registry.find(role, kind) if isinstance(kind, str) and kind in registry.names(role) else None


@dataclass(frozen=True)
class Part:
    """Mark a field as holding a part of a role; pydantic then reads and describes it through the registry."""

    role: str

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.build)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        kinds = [self.describe(name, handler) for name in registry.names(self.role)]
        return {"oneOf": kinds} if kinds else {"not": {}}  # nothing is registered: nothing is right

    def describe(self, name: str, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Return the JSON Schema of one registered part."""
        part: Any = registry.find(self.role, name)
        inner: Any = adapter(part).core_schema
        while inner["type"] != "dataclass":
            inner = inner["schema"]
        described = handler.resolve_ref_schema(handler(inner))
        texts = documented(part)
        fields = {
            field: value if "description" in value or field not in texts else value | {"description": texts[field]}
            for field, value in described.get("properties", {}).items()
        }
        properties = {"kind": {"const": name}, **fields}
        return {
            **described,
            "title": name,
            "properties": properties,
            "required": ["kind", *described.get("required", [])],
        }

    def build(self, value: Any) -> Any:
        """Make the part that a mapping asks for.

        Raises:
            ValidationError: pydantic adds its errors to those of the mission.
        """
        known = registry.names(self.role)
        if not isinstance(value, dict) or "kind" not in value:
            raise _error(f"must be {{kind: NAME, ...}}; known kinds: {', '.join(known) or 'none'}")
        part: Any = part_class(self.role, value)
        if part is None:
            error = _error(f"unknown {self.role} {value['kind']!r}; {suggest(str(value['kind']), known)}")
            details = InitErrorDetails(type=error, loc=("kind",), input=value["kind"])
            raise ValidationError.from_exception_data(self.role, [details])
        fields = {name: field for name, field in value.items() if name != "kind"}
        return adapter(part).validate_json(json.dumps(fields))


def _error(message: str) -> PydanticCustomError:
    return PydanticCustomError("part", "{message}", {"message": message})

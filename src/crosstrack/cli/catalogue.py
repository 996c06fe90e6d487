"""The list of what a mission can name."""

import inspect
from typing import Any

from crosstrack import registry
from crosstrack.mission.parts import adapter, documented
from crosstrack.policy.file import load, shipped

BOUNDS = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}


def show() -> int:
    """Print every registered part with its fields."""
    for role in registry.roles():
        print(f"{role}s" if registry.names(role) else f"{role}s: none")
        for name in registry.names(role):
            part = registry.find(role, name)
            print(f"  {name}: {(inspect.getdoc(part) or '').splitlines()[0]}")
            for line in field_lines(part):
                print(f"    {line}")
        print()
    print("policies that ship")
    for name in shipped():
        card = load(name).card
        print(f"  {name}: {card.task} by {card.options['action']}, trained by {card.algorithm} with {card.network}")
    return 0


def field_lines(part: Any) -> list[str]:
    """Return a line for each field of a part: name, default, allowed values and meaning."""
    schema = adapter(part).json_schema()
    described = schema["$defs"][part.__name__] if "$defs" in schema else schema
    texts, lines = documented(part), []
    for name, field in described.get("properties", {}).items():
        default = f" = {field['default']}" if field.get("default") is not None else ""
        allowed = f" [{allowed_values(field)}]" if allowed_values(field) else ""
        lines.append(f"{name}{default}{allowed}  {field.get('description', texts.get(name, ''))}".rstrip())
    return lines


def allowed_values(field: dict[str, Any]) -> str:
    """Return the words or the bounds of a field's JSON Schema."""
    if "anyOf" in field:
        return " or ".join(filter(None, map(allowed_values, field["anyOf"])))
    if "const" in field:
        return str(field["const"])
    if "enum" in field:
        return "|".join(map(str, field["enum"]))
    return ", ".join(f"{sign} {field[bound]:g}" for bound, sign in BOUNDS.items() if bound in field)

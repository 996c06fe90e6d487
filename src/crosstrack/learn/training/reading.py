"""From a preset, a file and flags to a training, all that is wrong with them said at once."""

import copy
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from pathlib import Path
from typing import Any, get_args, get_type_hints

from pydantic import ValidationError

from crosstrack.errors import InputError, Problem
from crosstrack.learn.training.config import LEARNING, NETWORKS, Training
from crosstrack.learn.training.presets import PRESETS
from crosstrack.mission.complaints import WANTED
from crosstrack.mission.parts import adapter, suggest
from crosstrack.mission.text import Place, parse, read_text, show

LASTING = {"steps", "until", "minutes", "checkpoint_every"}
"""fields that may be told anew when a training is resumed"""
FREE = {"options", "level"}
"""fields whose names are the task's"""
MOST_BYTES = 16_000_000_000
"""of what an algorithm may remember"""


@dataclass(frozen=True)
class Asked:
    """What is asked for beside the task, each None or empty where the preset decides."""

    algo: str | None = None
    preset: str | None = None
    file: Path | None = None
    """YAML with the fields of `Training`"""
    fields: Mapping[str, Any] | None = None
    """further fields of `Training`, None left out"""
    settings: Sequence[str] = ()
    """`PATH=VALUE`, such as `learning.gamma=0.98`"""

    def document(self) -> dict[str, Any]:
        """Return what is asked for as one document: the file, then the fields, then the settings.

        Raises:
            InputError: the file cannot be read, or a setting is not `PATH=VALUE`.
        """
        found = copy.deepcopy(mapping(self.file)) if self.file is not None else {}
        given = {"algo": self.algo, "preset": self.preset, **(self.fields or {})}
        found |= {name: value for name, value in given.items() if value is not None}
        problems = [problem for setting in self.settings for problem in applied(found, setting)]
        if problems:
            raise InputError("--set", problems)
        return found


def training(task: str, asked: Asked) -> Training:
    """Return a training that begins.

    Raises:
        InputError: everything that is wrong with what is asked for.
    """
    wanted = {**asked.document(), "task": task}
    source = str(asked.file) if asked.file is not None else "train"
    name, algo = wanted.get("preset", "tuned"), wanted.get("algo")
    base: dict[str, Any] = {"learning": {}}
    if isinstance(name, str) and name not in PRESETS:
        raise InputError(source, [Problem("preset", f"unknown preset {name!r}; {suggest(name, list(PRESETS))}")])
    if isinstance(name, str) and isinstance(algo, str) and algo in LEARNING:
        if algo not in PRESETS[name]:
            known = ", ".join(PRESETS[name])
            raise InputError(source, [Problem("preset", f"{name!r} is one of {known}, found algo {algo!r}")])
        base = merged(base, PRESETS[name][algo])
    return checked(merged(base, wanted), source)


def resumed(stored: Mapping[str, Any], task: str, asked: Asked, source: str) -> Training:
    """Return a training that goes on, as it was stored but for what may be told anew.

    Raises:
        InputError: it is not what is asked for, or was stored wrongly.
    """
    wanted = {**asked.document(), "task": task}
    before, after = dict(leaves(stored)), dict(leaves(merged(stored, wanted)))
    changed = [place for place in after if place[0] not in LASTING and before.get(place) != after[place]]
    problems = [
        Problem(show(place), f"was {before.get(place)!r} when the training began, and cannot be {after[place]!r} now")
        for place in changed
    ]
    if problems:
        raise InputError(source, problems)
    return checked(merged(stored, wanted), source)


def checked(document: Mapping[str, Any], source: str) -> Training:
    """Return the training that a document says, once all of it is found right.

    Raises:
        InputError: everything that is wrong with it.
    """
    top = {name: value for name, value in document.items() if name != "learning"}
    algo = top.get("algo")
    kind = LEARNING.get(algo) if isinstance(algo, str) else None
    told = document.get("learning", {})
    problems = list(unknown(Training, top))
    outline, faults = validated(Training, {**top, "learning": {}}, ())
    problems += faults
    learning = None
    if kind is not None:
        problems += unknown(kind, told, ("learning",))
        learning, faults = validated(kind, told, ("learning",))
        problems += faults
    if not problems:
        found: Training = replace(outline, learning=learning)
        problems += fits(found)
        if not problems:
            return found
    raise InputError(source, problems)


def validated(kind: Any, value: Any, place: Place) -> tuple[Any, list[Problem]]:
    """Return what plain values say of a dataclass, or what is wrong with them but for unknown names."""
    try:
        return adapter(kind).validate_json(json.dumps(value)), []
    except ValidationError as error:
        return None, list(complaints(error, place))


def complaints(error: ValidationError, place: Place) -> Iterator[Problem]:
    """Say what pydantic found, unknown names left out; a value that two alternatives refuse, once."""
    found: dict[str, str] = {}
    for detail in error.errors(include_url=False):
        tags = ("literal", "constrained")
        where = show((*place, *(part for part in detail["loc"] if not str(part).startswith(tags))))
        if detail["type"] == "missing":
            found[where] = "is required"
        elif detail["type"] != "unexpected_keyword_argument":
            wanted = WANTED.get(detail["type"], "").format(**detail.get("ctx", {})) or detail["msg"]
            before, _, _ = found.get(where, "").rpartition(", found ")
            wanted = f"{before} or {wanted.removeprefix('must be ')}" if before else wanted
            found[where] = f"{wanted}, found {detail['input']!r:.60}"
    yield from (Problem(where, message) for where, message in found.items())


def unknown(kind: type[Any], value: Any, place: Place = ()) -> Iterator[Problem]:
    """Find names that a dataclass has no field for, at any depth."""
    if isinstance(value, list):
        for index, item in enumerate(value):
            yield from unknown(kind, item, (*place, index))
    if not isinstance(value, Mapping):
        return
    hints = get_type_hints(kind)
    known = [each.name for each in fields(kind)]
    for name, inner in value.items():
        if name not in known:
            yield Problem(show((*place, name)), f"unknown; {suggest(str(name), known)}")
        elif name not in FREE and (held := held_by(hints[name])) is not None:
            yield from unknown(held, inner, (*place, name))


def held_by(hint: Any) -> type[Any] | None:
    """Return the one dataclass that a field holds, alone or in a tuple."""
    if isinstance(hint, type) and is_dataclass(hint):
        return hint
    found = [held for held in map(held_by, get_args(hint)) if held is not None]
    return found[0] if len(found) == 1 else None


def fits(asked: Training) -> Iterator[Problem]:
    """Find what does not fit together."""
    if asked.network not in NETWORKS[asked.algo]:
        pairs = "; ".join(f"{algo}: {', '.join(networks)}" for algo, networks in NETWORKS.items())
        yield Problem("network", f"{asked.algo} cannot train {asked.network!r}; there are: {pairs}")
    batch, rollout = getattr(asked.learning, "batch_size", 1), getattr(asked.learning, "n_steps", 1) * asked.envs
    if asked.algo == "ppo" and batch > rollout:
        yield Problem(
            "learning.batch_size",
            f"is more than the {rollout} decisions between updates (envs times learning.n_steps), found {batch}",
        )
    remembered = getattr(asked.learning, "buffer_size", None)
    if remembered is not None and remembered < asked.envs:
        yield Problem("learning.buffer_size", f"must be at least envs, {asked.envs}, found {remembered}")


def mapping(path: Path) -> dict[str, Any]:
    """Read a file of fields.

    Raises:
        InputError: it cannot be read, or holds something else.
    """
    value = parse(read_text(path), str(path)).value
    if not isinstance(value, dict):
        raise InputError(str(path), [Problem("", "must be a mapping of names to values, such as `steps: 1000000`")])
    return value


def applied(document: dict[str, Any], setting: str) -> list[Problem]:
    """Set one value of a document, `PATH=VALUE`; return what is wrong with the setting."""
    path, equals, text = setting.partition("=")
    *outer, last = path.strip().split(".")
    if not equals or not last:
        return [Problem(setting, "must be PATH=VALUE, such as learning.gamma=0.98")]
    target = document
    for name in outer:
        target = target.setdefault(name, {})
        if not isinstance(target, dict):
            return [Problem(setting, f"{name!r} holds no fields")]
    try:
        target[last] = parse(text, path).value
    except InputError as error:
        return list(error.problems)
    return []


def merged(base: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Return one document laid over another; mappings are joined, all else is replaced."""
    found = dict(base)
    for name, value in above.items():
        under = found.get(name)
        if isinstance(under, Mapping) and isinstance(value, Mapping):
            found[name] = merged(under, value)
        else:
            found[name] = value
    return found


def leaves(document: Mapping[str, Any], place: Place = ()) -> Iterator[tuple[Place, Any]]:
    """Yield the values of a document that are no mappings, with their places."""
    for name, value in document.items():
        if isinstance(value, Mapping) and value:
            yield from leaves(value, (*place, name))
        else:
            yield (*place, name), value

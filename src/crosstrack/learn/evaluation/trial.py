"""One flight of an evaluation, as a task."""

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import Any

from crosstrack.campaign.avoidance.trial import REFUSED, flown
from crosstrack.campaign.task import Task, task
from crosstrack.errors import InputError, Problem, Unreachable
from crosstrack.flight import loop
from crosstrack.flight.plan import Plan
from crosstrack.learn.evaluation.aimless import at_random
from crosstrack.learn.evaluation.missions import RANDOM, ROUTE, Where, mission, named
from crosstrack.mission.load import from_document
from crosstrack.mission.planning import along
from crosstrack.policy.file import load, to_bytes
from crosstrack.policy.policy import Policy


def trial_task(policy: str, digest: str, where: Where, seed: int, contestant: str) -> Task:
    """Return the task of one flight.

    Args:
        policy: its file, or its name where it ships
        digest: of the policy: another one of the same name is flown anew
        where: in which worlds
        seed: of the world
        contestant: what flies
    """
    labels = {"world": where.name, "seed": seed, "contestant": contestant}
    asked = {"policy": policy, "digest": digest, "family": where.family, "density": where.density}
    return task(f"{__name__}:{fly.__name__}", asked | {"labels": labels})


def digest(policy: Policy) -> str:
    """Return what tells a policy from any other."""
    return hashlib.sha256(to_bytes(policy)).hexdigest()


def fly(payload: Mapping[str, Any]) -> dict[str, Any]:
    """Fly one contestant in one world.

    Args:
        payload: see `trial_task`

    Returns:
        `labels`; `document`, the mission; `outcome`, its key; `summary` of the flight, None where it did not begin;
        `trace` and `courses`, see `campaign.avoidance.trial. Cross-track errors on a route are those to
        the course: its corners are rounded for all.

    Raises:
        InputError: the policy is not the one that was asked for.
    """
    labels = payload["labels"]
    policy = reading(payload["policy"], payload["digest"])
    file, where = named(payload["policy"]), Where(payload["family"], payload["density"])
    said = mission(file, policy.card, where, labels["seed"], labels["contestant"])
    known = {"labels": labels, "document": said}
    try:
        plan = from_document(said, {file: to_bytes(policy)}).build()
    except Unreachable:
        return known | REFUSED
    if labels["contestant"] == RANDOM:
        plan = replace(plan, avoiders=(at_random(plan.avoiders[0], labels["seed"]),))
    if where.family == ROUTE:
        plan = replace(plan, route=along(plan.course.path))
    warm(labels["contestant"], plan)
    return known | flown(loop.fly(plan))


@cache
def reading(name: str, expected: str) -> Policy:
    """Read a policy once."""
    policy = load(name)
    if digest(policy) != expected:
        raise InputError(name, [Problem("", "has changed since the evaluation began")])
    return policy


WARM: set[str] = set()


def warm(contestant: str, plan: Plan) -> None:
    """Compile what a contestant needs, before its first flight."""
    if contestant not in WARM:
        loop.warm_up(plan)
        WARM.add(contestant)

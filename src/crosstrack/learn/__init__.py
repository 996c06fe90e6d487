"""Learning to fly: environments, training, evaluation.

Importing this tells gymnasium of the environments `crosstrack/Avoid-v0`, `crosstrack/Follow-v0`, `crosstrack/Hover-v0`.
"""

from typing import Any

import gymnasium

TASKS = ("Avoid", "Follow", "Hover")


def make_vector(num_envs: int, task: str, seed: int = 0, **options: Any) -> Any:
    """Return many vehicles of a task, with options of its own, for `gymnasium.make_vec`."""
    from crosstrack.learn.tasks import find
    from crosstrack.learn.vector import Vector

    return Vector(find(task)(**options), num_envs, seed)


for name in TASKS:
    gymnasium.register(
        id=f"crosstrack/{name}-v0",
        entry_point="crosstrack.learn.single:Single",
        vector_entry_point="crosstrack.learn:make_vector",
        kwargs={"task": name.lower()},
    )

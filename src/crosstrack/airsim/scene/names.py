"""Names of things, and patterns that they are found by."""

import re
import warnings

MOST_REPEATS = 4
LONGEST = 200
"""characters of a name or a pattern"""


def pattern(text: str, ignoring_case: bool = False) -> re.Pattern[str]:
    """Return the regular expression of a client.

    Matching may take time that grows with a power of the length of a name, the power being the number of repeats; so a
    pattern may have only a few, and none of a group.

    Raises:
        ValueError: it is none, is too long, or repeats too much.
    """
    if len(text) > LONGEST:
        raise ValueError(f"a pattern of {len(text)} characters; at most {LONGEST} are allowed")
    bare = re.sub(r"\\.", "x", text, flags=re.DOTALL)
    bare = re.sub(r"\[\^?\]?[^\]]*\]", "x", bare)
    repeats = len(re.findall(r"[*+?{]", bare.replace("(?:", "(")))
    if repeats > MOST_REPEATS or re.search(r"\)[*+?{]", bare):
        raise ValueError(f"the pattern {text!r}: at most {MOST_REPEATS} repeats are allowed, and none of a group")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", FutureWarning)
            return re.compile(text, re.IGNORECASE if ignoring_case else 0)
    except re.error as error:
        raise ValueError(f"the pattern {text!r}: {error}") from None


def numbered(name: str, taken: list[str]) -> str:
    """Return a name that is not taken: with one number more than the largest at the end of those that contain it."""
    like = [other for other in taken if name in other]
    if not like:
        return name
    ends = [re.search(r"\d*$", other) for other in like]
    return f"{name}{max((int(end[0]) for end in ends if end and end[0]), default=0) + 1}"


def first_number(name: str) -> int:
    """Return the segmentation number that AirSim gives a name: 5 and the codes of its small letters, modulo 256."""
    return (5 + sum(ord(letter) for letter in name.lower() if ord(letter) >= ord("a"))) % 256

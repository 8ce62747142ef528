"""What became of a file, in the same words for images, meshes and models."""

from typing import NamedTuple

RIGHT = "right"
REFUSED = "refused"
# Independent readers refuse it, too.
REFUSED_BY_ALL = "refused by all"
WRONG = "wrong"
# There is nothing to compare with: a codec that no independent reader here has.
NOT_COMPARED = "not compared"
# Panicked, crashed or ran over the time limit.
FAILED = "failed"
VERDICTS = (RIGHT, REFUSED, REFUSED_BY_ALL, NOT_COMPARED, WRONG, FAILED)


class Outcome(NamedTuple):
    """A verdict, its reason in words, and the largest difference where there is one."""

    verdict: str
    reason: str = ""
    difference: float | None = None


class RefusedError(Exception):
    """uvgraft refuses a file, and this is its reason."""


class PeerError(Exception):
    """An independent reader cannot read a file."""


def first_line(error):
    """Return an exception's message, or its name if it has none."""
    lines = str(error).strip().splitlines()
    return lines[0] if lines else type(error).__name__

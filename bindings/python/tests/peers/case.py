"""A file that the tests write, and what must become of it."""

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest

from peers import kinds
from peers.outcome import REFUSED, REFUSED_BY_ALL, RIGHT


class Case(NamedTuple):
    """A file of some kind.

    `write` makes it at a path. `refused` is a word that the message must have, or None if the file
    must be read.
    """

    name: str
    write: Callable[[Path], object]
    refused: str | None = None


def check(kind, case, folder):
    """Write a file and compare it."""
    path = folder / case.name
    case.write(path)
    outcome = kinds.compare(kind, path)
    if case.refused is None:
        assert outcome.verdict == RIGHT, outcome
    else:
        assert outcome.verdict in (REFUSED, REFUSED_BY_ALL), outcome
        assert case.refused in outcome.reason


def parameters(cases):
    """Return parameters of a test, named by their files."""
    return [pytest.param(case, id=case.name) for case in cases]

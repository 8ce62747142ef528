"""Warnings that point at the code that called the package."""

from __future__ import annotations

import os
import sys
import warnings
from collections.abc import Iterable

_PACKAGE = os.path.dirname(os.path.abspath(__file__)) + os.sep


def warn(texts: Iterable[str]) -> None:
    """Issue warnings; the compiled part calls this in the thread of its caller.

    Parameters
    ----------
    texts : iterable of str
        What is warned of.
    """
    level = _level_of_caller()
    for text in texts:
        warnings.warn(text, UserWarning, stacklevel=level)


def _level_of_caller() -> int:
    """Return the `stacklevel`, in the calling function, of the code that called the package."""
    frame, level = sys._getframe(1), 1
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_PACKAGE):
        frame, level = frame.f_back, level + 1
    return level

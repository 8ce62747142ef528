"""Progress of long calls: callables, and bars like those of tqdm."""

from __future__ import annotations

import contextlib
import functools
import sys
from collections.abc import Callable
from types import TracebackType
from typing import Any, Protocol, TypeAlias


class Progress(Protocol):
    """A function that is told how far a call is.

    Called as ``progress(step, steps, rms)``: before the first step, with step 0, and after each.
    An exception that it raises ends the call.
    """

    def __call__(self, step: int, steps: int, rms: float, /) -> object:
        """Take note of a step: its number, the largest possible number, and the error left."""


class Bar(Protocol):
    """What is needed of a bar: those of tqdm have it."""

    def update(self, n: int = 1, /) -> object:
        """Advance by some steps."""


# True for a bar, a function, a bar, or what makes one: `tqdm.tqdm`, `tqdm.notebook.tqdm`.
GivenProgress: TypeAlias = Progress | Bar | type[Any] | Callable[..., Any] | bool | None


class Reporter:
    """Tells one call's progress to whatever the user gave.

    Parameters
    ----------
    progress : bool, callable, bar, or class of bars
        True shows a bar of tqdm if it is installed, or else a line of text on standard error. A
        bar, an object with ``update(n)``, is advanced and stays open; a class of bars, such as
        ``tqdm.notebook.tqdm``, or a `functools.partial` of one, is called with ``total`` and
        ``desc``, and its bar is closed at the end. Anything else is called as
        ``progress(step, steps, rms)``.
    description : str
        Shown beside a bar.

    Raises
    ------
    TypeError
        If `progress` is none of these.
    """

    def __init__(self, progress: GivenProgress, description: str = "") -> None:
        self._description = description
        self._done = 0
        self._bar: Any = None
        self._make: Callable[..., Any] | None = None
        self._call: Callable[..., object] | None = None
        if progress is True:
            self._make = _default_bar()
        elif _is_bar_class(progress):
            self._make = progress  # type: ignore[assignment] # a class of bars is callable
        elif callable(getattr(progress, "update", None)):
            self._bar = progress
        elif callable(progress):
            self._call = progress
        elif progress is not None and progress is not False:
            found = type(progress).__name__
            raise TypeError(f"progress must be a bool, a callable or a progress bar, got {found}")

    def __call__(self, step: int, steps: int, rms: float) -> None:
        """Report a step."""
        if self._call is not None:
            self._call(step, steps, rms)
            return
        if self._bar is None and self._make is not None:
            self._bar = self._make(total=steps, desc=self._description)
        if self._bar is None:
            return
        describe = getattr(self._bar, "set_postfix_str", None)
        if describe is not None:
            describe(f"rms {rms:.5f}", refresh=False)
        self._bar.update(step - self._done)
        self._done = step

    def close(self) -> None:
        """Close the bar, unless it is the user's own."""
        bar, self._bar = self._bar, None
        if self._make is not None and bar is not None:
            close = getattr(bar, "close", None)
            if close is not None:
                close()

    def __enter__(self) -> Reporter:
        """Return the reporter."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        """Close the bar."""
        self.close()


def reporter(progress: GivenProgress, description: str = "") -> Reporter | None:
    """Make a reporter; None if no progress is wanted.

    Parameters
    ----------
    progress, description
        As for `Reporter`.
    """
    if progress is None or progress is False:
        return None
    return Reporter(progress, description)


def _is_bar_class(progress: object) -> bool:
    while isinstance(progress, functools.partial):
        progress = progress.func
    return isinstance(progress, type) and callable(getattr(progress, "update", None))


def _default_bar() -> Callable[..., Any]:
    try:
        # Shows a widget in notebooks.
        from tqdm.auto import tqdm  # noqa: PLC0415 - an optional dependency
    except ImportError:
        return TextBar
    return tqdm  # type: ignore[no-any-return] # tqdm has no types


class TextBar:
    """A line of text on standard error that says how far a call is.

    A terminal shows each step, anything else the last one only. A step that cannot be shown, since
    nobody reads or the disk is full, changes nothing.
    """

    def __init__(self, total: int, desc: str = "") -> None:
        self._total, self._name = total, desc or "step"
        self._done, self._note = 0, ""
        # Programs without a console have none.
        self._is_live = sys.stderr is not None and sys.stderr.isatty()

    def set_postfix_str(self, text: str, refresh: bool = True) -> None:
        """Set what follows the number of steps."""
        self._note = text

    def update(self, n: int = 1) -> None:
        """Advance by some steps."""
        self._done += n
        if self._is_live:
            self._show(f"\r{self._line()}")

    def close(self) -> None:
        """End the line."""
        self._show("\n" if self._is_live else f"{self._line()}\n")

    def _show(self, text: str) -> None:
        if sys.stderr is not None:
            # A closed stream is a ValueError.
            with contextlib.suppress(OSError, ValueError):
                sys.stderr.write(text)
                sys.stderr.flush()

    def _line(self) -> str:
        return f"{self._name} {self._done}/{self._total} {self._note}".rstrip()

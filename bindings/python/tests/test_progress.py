"""Progress of long calls."""

import builtins
import functools
import io
import sys

import pytest
import tqdm
from scenes import noise

import uvgraft
from uvgraft._progress import Reporter, reporter

STEPS = [(0, 20, 0.5), (1, 20, 0.25), (2, 20, 0.125)]


def report(progress, description="fit"):
    """Report some steps of twenty."""
    with reporter(progress, description) as found:
        for step in STEPS:
            found(*step)


def test_a_function():
    calls = []
    report(lambda *arguments: calls.append(arguments))
    assert calls == STEPS


def test_an_exception_is_the_callers():
    with pytest.raises(ZeroDivisionError):
        report(lambda step, steps, rms: step // 0)


def test_nothing():
    assert reporter(None) is None
    assert reporter(False) is None


def test_a_bar_of_the_user_stays_open():
    with tqdm.tqdm(total=20, file=io.StringIO()) as bar:
        report(bar)
        assert bar.n == 2
        assert not bar.disable
        bar.update(1)


class Bar(tqdm.tqdm):
    """Remembers the bars that were made."""

    made = ()

    def __init__(self, *arguments, **options):
        super().__init__(*arguments, file=io.StringIO(), **options)
        type(self).made += (self,)


@pytest.mark.parametrize("make", [Bar, functools.partial(functools.partial(Bar), ncols=40)])
def test_a_class_of_bars(monkeypatch, make):
    monkeypatch.setattr(Bar, "made", ())
    report(make)
    (bar,) = Bar.made
    assert (bar.n, bar.total, bar.desc) == (2, 20, "fit")
    assert "rms 0.12500" in bar.postfix
    # Closed bars are disabled.
    assert bar.disable


def test_a_bar_is_closed_when_the_call_fails(monkeypatch):
    monkeypatch.setattr(Bar, "made", ())
    with pytest.raises(ZeroDivisionError), Reporter(Bar) as found:
        found(0, 20, 0.5)
        raise ZeroDivisionError
    assert Bar.made[0].disable


def test_true_shows_a_bar_of_tqdm(capsys):
    report(True)
    shown = capsys.readouterr().err
    assert "2/20" in shown
    assert "fit:" in shown
    assert "rms 0.12500" in shown


def without_tqdm(monkeypatch):
    """Make imports of tqdm fail."""
    original = builtins.__import__

    def refuse(name, *arguments, **options):
        if name.split(".")[0] == "tqdm":
            raise ImportError(name)
        return original(name, *arguments, **options)

    monkeypatch.setattr(builtins, "__import__", refuse)


def test_true_without_tqdm_is_a_line(monkeypatch, capsys):
    without_tqdm(monkeypatch)
    report(True)
    assert capsys.readouterr().err == "fit 2/20 rms 0.12500\n"


class Full(io.StringIO):
    """A stream on a full disk."""

    def write(self, text):
        raise OSError(28, "No space left on device")


@pytest.mark.parametrize("is_terminal", [False, True])
@pytest.mark.parametrize("stream", [Full, "closed", None])
def test_a_line_that_cannot_be_shown_changes_nothing(monkeypatch, stream, is_terminal):
    without_tqdm(monkeypatch)
    found = io.StringIO() if stream == "closed" else stream and stream()
    if found is not None:
        found.isatty = lambda: is_terminal
    if stream == "closed":
        found.close()
    monkeypatch.setattr(sys, "stderr", found)
    report(True)


def test_the_line_on_a_terminal(monkeypatch):
    without_tqdm(monkeypatch)
    terminal = io.StringIO()
    terminal.isatty = lambda: True
    monkeypatch.setattr(sys, "stderr", terminal)
    report(True)
    assert terminal.getvalue().split("\r")[1:] == [
        "fit 0/20 rms 0.50000",
        "fit 1/20 rms 0.25000",
        "fit 2/20 rms 0.12500\n",
    ]


@pytest.mark.parametrize("given", [3, "yes", object()])
def test_what_is_neither(given):
    with pytest.raises(TypeError, match="progress must be a bool, a callable or a progress bar"):
        reporter(given)


def test_a_fit(pair):
    with tqdm.tqdm(total=3, file=io.StringIO()) as bar, Reporter(bar) as found:
        graft = uvgraft.Graft(pair, size=32)
        fitted = graft.fit(noise(32, 32, 3), steps=3, min_gain=0.0, progress=found)
        assert bar.n == fitted.steps
        assert fitted.steps > 0

"""The command ``uvgraft`` in a process of its own.

The command takes over the process that it runs in: it handles signals and may end it. So it is run
by another interpreter, which imports this package from where this process did, as processes that
`multiprocessing` spawns do.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import sysconfig
import warnings
from collections.abc import Iterator, Sequence
from typing import NamedTuple, NoReturn

from uvgraft._uvgraft import Error, get_threads

StrPath = str | os.PathLike[str]

# What an interrupted command may take to remove unfinished outputs.
_GRACE_S = 5.0
_INTERRUPTED = 130
_PACKAGE = os.path.dirname(os.path.abspath(__file__))
_PROGRAM = "import sys; sys.path[:] = {path!r}; from uvgraft.__main__ import main; sys.exit(main())"

_MESSAGE = re.compile(r"(error|warning|note): ")
# Advice that only helps at a command line.
_USAGE = re.compile(r"\n+(Usage: |For more information, try).*", re.DOTALL)
_OF_SYSTEM = re.compile(
    r"(?:.*: )?(?P<path>[^\n]+?): (?P<why>[^:\n]+) \(os error (?P<code>\d+)\)\Z"
)


class Finished(NamedTuple):
    """What a command printed.

    Attributes
    ----------
    report : str
        Its standard output.
    notes : list of str
        What it assumed, and what else is neither an error nor a warning.
    """

    report: str
    notes: list[str]


def run(
    arguments: Sequence[StrPath],
    *,
    threads: int | None = None,
    folder: StrPath | None = None,
) -> Finished:
    """Run the command and wait for its end.

    Parameters
    ----------
    arguments : sequence of str or path
        Those of the command, its own name left out: ``["render", "me.glb", "-o", "me.png"]``.
    threads : int, optional
        Number of threads, 0 for one per processor; by default what `set_threads` says.
    folder : path, optional
        A temporary folder, which messages leave out of the paths that they name.

    Returns
    -------
    Finished
        What it printed.

    Warns
    -----
    UserWarning
        For each warning of the command.

    Raises
    ------
    uvgraft.Error
        If the command fails, or cannot be run.
    OSError
        If it fails because the system rejects a path: `FileNotFoundError` and so on.
    KeyboardInterrupt
        If it is interrupted. When this process is, the command is ended first.
    """
    count = get_threads() if threads is None else threads
    subcommand, *others = (os.fspath(word) for word in arguments)
    code, report, messages = _run([*_program(), subcommand, f"--threads={count}", *others])
    if folder is not None:
        prefix = os.path.join(os.fspath(folder), "")
        report, messages = report.replace(prefix, ""), messages.replace(prefix, "")
    found = list(_messages(messages))
    for kind, text in found:
        if kind == "warning":
            warnings.warn(text, UserWarning, stacklevel=_callers())
    if code != 0:
        _fail(code, [text for kind, text in found if kind == "error"], messages)
    return Finished(report, [text for kind, text in found if kind == "note"])


def _program() -> list[str]:
    """Find an interpreter and what it runs, or the installed script."""
    interpreter = sys.executable
    # An application that embeds Python may be named here in its place, and would start again.
    is_python = re.match(r"python|pypy", os.path.basename(interpreter or ""), re.IGNORECASE)
    if is_python and os.path.isfile(interpreter) and not getattr(sys, "frozen", False):
        return [
            interpreter,
            "-c",
            _PROGRAM.format(path=[entry for entry in sys.path if isinstance(entry, str)]),
        ]
    scripts = [sysconfig.get_path("scripts"), os.path.join(sys.prefix, "bin")]
    for folder in [*scripts, None]:
        script = shutil.which("uvgraft", path=folder)
        if script is not None:
            return [script]
    raise Error(
        "cannot run the command: sys.executable is not a Python interpreter, and no script "
        f"`uvgraft` was found in {scripts[0]} or on the path"
    )


def _environment() -> dict[str, str]:
    """Return this process's variables without those that colour messages."""
    variables = {name: value for name, value in os.environ.items() if name != "CLICOLOR_FORCE"}
    return {**variables, "NO_COLOR": "1"}


def _run(words: list[str]) -> tuple[int, str, str]:
    """Run a program; return its exit code, standard output and standard error."""
    try:
        child = subprocess.Popen(
            words,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            env=_environment(),
        )
    except OSError as reason:
        raise Error(f"cannot run {words[0]}: {reason}") from reason
    with child:
        try:
            output, messages = child.communicate()
        except BaseException:
            _end(child)
            raise
    return child.returncode, _text(output), _text(messages)


def _end(child: subprocess.Popen[bytes]) -> None:
    """End a command and wait for it, so that it leaves neither files nor a zombie."""
    child.terminate()
    try:
        child.wait(timeout=_GRACE_S)
    except BaseException as reason:
        child.kill()
        child.wait()
        if not isinstance(reason, subprocess.TimeoutExpired):
            raise


def _text(output: bytes) -> str:
    return output.decode(errors="replace").replace("\r\n", "\n")


def _messages(text: str) -> Iterator[tuple[str, str]]:
    """Take standard error apart: kinds and texts, which may have several lines."""
    kind, lines = "", list[str]()
    for line in [*text.splitlines(), "note: "]:
        start = _MESSAGE.match(line)
        if start is None:
            lines.append(line)
            continue
        if kind:
            yield kind, "\n".join(lines).rstrip()
        kind, lines = start[1], [line[start.end() :]]


def _callers() -> int:
    """Return the `stacklevel`, in the calling function, of the code that called the package."""
    frame, level = sys._getframe(1), 1
    while frame.f_back is not None and frame.f_code.co_filename.startswith(_PACKAGE + os.sep):
        frame, level = frame.f_back, level + 1
    return level


def _fail(code: int, errors: list[str], messages: str) -> NoReturn:
    if code in (_INTERRUPTED, -signal.SIGINT):
        raise KeyboardInterrupt
    if not errors:
        ended = f"was ended by signal {-code}" if code < 0 else f"ended with code {code}"
        raise Error(f"the command {ended}: {messages.strip()[-2000:] or 'no message'}")
    message = _USAGE.sub("", "\n".join(errors)).strip()
    of_system = _OF_SYSTEM.match(message)
    if of_system is not None:
        raise OSError(int(of_system["code"]), of_system["why"], of_system["path"])
    raise Error(message)

"""Compares files in processes of their own, so that one that aborts or hangs ends only itself."""

import contextlib
import json
import os
import select
import subprocess
import sys
import threading
import traceback
from pathlib import Path

from peers import kinds
from peers.outcome import FAILED, NOT_COMPARED, Outcome

_READ = "read"
_here = threading.local()


class Worker:
    """A process that compares files one after the other, started again after a crash."""

    def __init__(self, limit):
        self.limit = limit
        self.process = None

    def run(self, kind, path):
        """Compare a file and return the outcome."""
        process = self._started()
        process.stdin.write(json.dumps([kind, os.fspath(path)]).encode() + b"\n")
        done = False
        while True:
            line = self._line()
            if line == _READ.encode() + b"\n":
                done = True
            elif line:
                return Outcome(*json.loads(line))
            else:
                return self._ended(line is None, done)

    def _started(self):
        if self.process is None:
            words = [sys.executable, "-u", "-m", "peers.worker"]
            self.process = subprocess.Popen(
                words,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                # A line that waits in a buffer would be missed by select.
                bufsize=0,
                env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
            )
        return self.process

    def _line(self):
        """Return the next line, an empty one at a crash, None at the time limit."""
        ready, _, _ = select.select([self.process.stdout], [], [], self.limit)
        return self.process.stdout.readline() if ready else None

    def _ended(self, too_late, done):
        if too_late:
            self.process.kill()
        code = self.process.wait()
        self.process = None
        what = f"ran over {self.limit:g} s" if too_late else f"crashed with exit code {code}"
        return Outcome(NOT_COMPARED, f"the peer {what}") if done else Outcome(FAILED, what)


def start(limit):
    """Prepare a thread to compare files."""
    _here.worker = Worker(limit)


def run(job):
    """Compare the file of a job: its kind and path."""
    return _here.worker.run(*job)


def outcome_of(kind, path, progress):
    """Compare a file and turn a panic into an outcome."""
    try:
        return kinds.compare(kind, path, progress)
    except KeyboardInterrupt:
        raise
    # PyO3's PanicException is not an Exception.
    except BaseException as error:
        what = "panicked" if type(error).__name__ == "PanicException" else "raised"
        where = traceback.extract_tb(error.__traceback__)[-1]
        return Outcome(
            FAILED, f"{what} {type(error).__name__} in {where.name}: {str(error).strip()[:200]}"
        )


def main():
    # What libraries print must not be taken for an answer.
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)
    for line in sys.stdin:
        kind, path = json.loads(line)
        with contextlib.redirect_stdout(sys.stderr):
            outcome = outcome_of(kind, Path(path), lambda: print(_READ, file=answers, flush=True))
        print(json.dumps(outcome), file=answers, flush=True)


if __name__ == "__main__":
    main()

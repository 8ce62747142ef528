"""Requests run in this process: what ends them, where they warn, and what they leave behind."""

import contextlib
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from scenes import noise

import uvgraft

# A call that is interrupted returns within this time, also on a machine with much else to do.
PROMPT_S = 1.0

LINUX = pytest.mark.skipif(sys.platform != "linux", reason="needs /proc")


@pytest.fixture(autouse=True)
def interruptible():
    """Jobs that a shell starts in the background ignore SIGINT, and so does what they start."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


class Pipe:
    """A file that nobody writes to: what reads it waits."""

    def __init__(self, path):
        os.mkfifo(path)
        self.path = path
        self._writer = None

    def wait_for_reader(self):
        """Wait until somebody reads."""

        def is_read():
            # Fails while nobody does.
            with contextlib.suppress(OSError):
                self._writer = os.open(self.path, os.O_WRONLY | os.O_NONBLOCK)
            return self._writer is not None

        wait_until(is_read)

    def feed(self, data):
        """Give data to the reader, who thinks that it is all."""
        os.set_blocking(self._writer, True)
        with contextlib.suppress(BrokenPipeError), os.fdopen(self._writer, "wb") as file:
            file.write(data)
        self._writer = None

    def close(self):
        """Let go of readers, with what looks like the end of the file."""
        both = os.open(self.path, os.O_RDWR)
        # Nobody can begin to wait.
        self.path.unlink()
        for end in [both] if self._writer is None else [both, self._writer]:
            os.close(end)


@pytest.fixture
def pipe(tmp_path):
    """A file whose readers wait."""
    pipe = Pipe(tmp_path / "pipe")
    yield pipe
    pipe.close()


def workers():
    """Count the threads of the package in this process."""
    names = (path.read_text().strip() for path in Path("/proc/self/task").glob("*/comm"))
    return sum(name.startswith("uvgraft-") for name in names)


def wait_until(condition):
    """Wait for something that takes a moment."""
    end = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.01)


def avatar(demo, **options):
    """Make a small avatar of the built-in example."""
    given = {"onto": "#c08a70", "size": 64, "body": "demo", "mouth": "none", **options}
    pair = given.pop("pair", demo / "head_to_body.uvpair")
    return uvgraft.avatar(pair, given.pop("face", demo / "face.png"), **given)


def calls(demo, pipe):
    """Calls that wait for a pipe, each in another place."""
    photo = demo / "face.png"
    return {
        "avatar": lambda: avatar(demo, face=pipe.path),
        "avatar_from_photos": lambda: uvgraft.avatar_from_photos(
            photo, body="demo", pair=pipe.path, size=64
        ),
        "selfie": lambda: uvgraft.selfie(photo, pipe.path),
        "render": lambda: uvgraft.render(pipe.path),
    }


def interrupted(call, pipe=None, number=signal.SIGINT, kind=KeyboardInterrupt):
    """Interrupt a call, once it reads a pipe if there is one, and return how long it went on."""
    sent = []

    def interrupt():
        time.sleep(0.3) if pipe is None else pipe.wait_for_reader()
        sent.append(time.monotonic())
        os.kill(os.getpid(), number)

    thread = threading.Thread(target=interrupt)
    thread.start()
    try:
        with pytest.raises(kind):
            call()
        return time.monotonic() - sent[0]
    finally:
        thread.join()


@pytest.mark.parametrize("name", ["avatar", "avatar_from_photos", "selfie", "render"])
def test_an_interruption_ends_a_call(demo, pipe, name):
    assert interrupted(calls(demo, pipe)[name], pipe) < PROMPT_S


@LINUX
def test_an_interruption_ends_a_call_that_computes(demo):
    before = workers()
    # Both take seconds, on any machine.
    path = demo / "avatar.glb"
    assert interrupted(lambda: uvgraft.render(path, size=4096, threads=1)) < PROMPT_S
    slow = {"size": 4096, "threads": 1, "texture_format": "webp"}
    assert interrupted(lambda: avatar(demo, **slow)) < PROMPT_S
    wait_until(lambda: workers() <= before)


def test_an_exception_of_another_handler_ends_a_call(demo, pipe):
    class AlarmError(Exception):
        pass

    def ring(number, frame):
        raise AlarmError

    before = signal.signal(signal.SIGUSR1, ring)
    try:
        late = interrupted(calls(demo, pipe)["avatar"], pipe, signal.SIGUSR1, AlarmError)
    finally:
        signal.signal(signal.SIGUSR1, before)
    assert late < PROMPT_S


def test_a_handler_that_raises_nothing_ends_nothing(demo, pipe):
    rung = []
    before = signal.signal(signal.SIGUSR1, lambda number, frame: rung.append(time.monotonic()))

    def ring():
        pipe.wait_for_reader()
        os.kill(os.getpid(), signal.SIGUSR1)
        # Handled meanwhile, not when the call has ended.
        wait_until(lambda: rung)
        pipe.feed((demo / "face.png").read_bytes())

    thread = threading.Thread(target=ring)
    thread.start()
    try:
        made = avatar(demo, face=pipe.path)
    finally:
        thread.join()
        signal.signal(signal.SIGUSR1, before)
    assert len(rung) == 1
    assert made.data == avatar(demo).data


@LINUX
def test_what_was_interrupted_ends_and_writes_nothing(demo, pipe, tmp_path):
    outputs = {"output": tmp_path / "a.glb", "preview": tmp_path / "b.png"}
    before = workers()
    interrupted(lambda: avatar(demo, face=pipe.path, threads=3, **outputs), pipe)
    assert workers() >= 3
    # The work goes on from here, to its next step.
    pipe.feed((demo / "face.png").read_bytes())
    wait_until(lambda: workers() <= before)
    assert [path.name for path in tmp_path.iterdir()] == ["pipe"]
    # The next call has threads of its own.
    assert avatar(demo, threads=3).data == avatar(demo).data


@LINUX
def test_threads_are_as_many_as_said(demo):
    program = """import sys, uvgraft
from pathlib import Path
def workers():
    names = [path.read_text() for path in Path("/proc/self/task").glob("*/comm")]
    return sum(name.startswith("uvgraft-") for name in names)
uvgraft.render(sys.argv[1], size=16, threads=3)
print(workers())
uvgraft.set_threads(2)
uvgraft.render(sys.argv[1], size=16)
print(workers())
"""
    words = [sys.executable, "-c", program, demo / "avatar.glb"]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    # Pools are kept, so those of the first call are still there.
    assert done.stdout.split() == ["3", "5"]


def test_warnings_point_at_the_caller(demo):
    face = uvgraft.read_image(demo / "face.png") / np.float32(255)
    face[:9, :9] = np.nan
    with pytest.warns(UserWarning) as caught:
        avatar(demo, face=face)
        direct = uvgraft.avatar(
            demo / "head_to_body.uvpair", face, onto="#c08a70", size=64, body="demo"
        )
    assert direct.report
    # Those of the second call are of its line here, those of the first of `avatar` above.
    assert {warning.filename for warning in caught} == {__file__}
    assert all(str(warning.message).startswith("face: ") for warning in caught)
    lines = {warning.lineno for warning in caught}
    assert len(lines) == 2


def test_warnings_may_be_errors(demo):
    face = uvgraft.read_image(demo / "face.png") / np.float32(255)
    face[:9, :9] = np.nan
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(UserWarning, match="NaN"):
            avatar(demo, face=face)


def test_warnings_come_before_a_failure(demo):
    face = uvgraft.read_image(demo / "face.png") / np.float32(255)
    face[:9, :9] = np.nan
    with (
        pytest.warns(UserWarning, match="NaN"),
        pytest.raises(uvgraft.Error, match="fill: "),
    ):
        avatar(demo, face=face, fill=noise(3, 5, 3))


def test_nothing_is_written_beside_the_outputs(demo, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    made = avatar(demo, face=uvgraft.read_image(demo / "face.png"))
    made.render(size=16)
    with contextlib.suppress(uvgraft.Error):
        made.html()
    with pytest.raises(uvgraft.Error):
        made.render(size=16, expression="none")
    assert list(tmp_path.iterdir()) == []


def test_colours_of_terminals_are_not_in_messages():
    program = """import uvgraft
try:
    uvgraft.selfie("photo.png", "demo", size=9999, threads=1)
except uvgraft.Error as error:
    print(ascii(str(error)))
"""
    environment = {**os.environ, "CLICOLOR_FORCE": "1"}
    words = [sys.executable, "-c", program]
    done = subprocess.run(words, capture_output=True, text=True, env=environment, check=False)
    assert "\\x1b" not in done.stdout + done.stderr


def test_calls_at_once(demo):
    wanted = avatar(demo).data
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda _: avatar(demo, threads=2).data, range(8)))
    assert found == [wanted] * 8


def picture(path):
    """Draw a picture in another process."""
    return uvgraft.render(path, size=32, threads=2)


@pytest.mark.parametrize("how", ["fork", "forkserver", "spawn"])
@pytest.mark.filterwarnings("ignore:.*multi-threaded.*:DeprecationWarning")
def test_forked_workers(demo, how):
    # The parent's threads exist when it forks.
    wanted = picture(demo / "avatar.glb")
    context = multiprocessing.get_context(how)
    with context.Pool(2) as pool:
        for found in pool.map_async(picture, [demo / "avatar.glb"] * 4).get(timeout=120):
            np.testing.assert_array_equal(found, wanted)


def test_the_lock_is_released(demo):
    # A second thread counts while the first works.
    counted = 0
    done = threading.Event()

    def work():
        try:
            uvgraft.render(demo / "avatar.glb", size=1024, threads=1)
        finally:
            done.set()

    worker = threading.Thread(target=work)
    worker.start()
    while not done.wait(0.0005):
        counted += 1
    worker.join()
    assert counted > 20


@LINUX
def test_memory_is_given_back(demo):
    # In a process of its own, whose memory nothing else has used.
    program = """import os, resource, sys, uvgraft
def resident():
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize()
def make():
    uvgraft.avatar(*sys.argv[1:], onto="#c08a70", size=1024, body="demo", threads=2)
    return resident()
sizes = [resident(), *(make() for _ in range(5))]
print(*sizes, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024)
"""
    files = [demo / "head_to_body.uvpair", demo / "face.png"]
    done = subprocess.run(
        [sys.executable, "-c", program, *files], capture_output=True, text=True, check=True
    )
    before, *after, peak = map(int, done.stdout.split())
    # What stays is code, the figure's tables, and what the C library does not give back.
    assert max(after) - before < (peak - before) / 2
    assert after[-1] - after[0] < (peak - before) / 8

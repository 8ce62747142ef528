"""The command in a process of its own."""

import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import warnings
from pathlib import Path

import pytest

import uvgraft
from uvgraft import _command
from uvgraft._command import run


@pytest.fixture(autouse=True)
def interruptible():
    """Jobs that a shell starts in the background ignore SIGINT, and so does what they start."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_a_report():
    finished = run(["render", "--help"])
    assert finished.report.startswith("Render a GLB")
    assert finished.notes == []


def test_errors_are_the_commands_own(demo, tmp_path):
    with pytest.raises(uvgraft.Error) as caught:
        run(["render", demo / "head.obj", "-o", tmp_path / "out.png"])
    assert str(caught.value).startswith(f"{demo / 'head.obj'}: not a glTF file")


def test_errors_of_usage_have_no_advice_for_terminals(demo, tmp_path):
    with pytest.raises(uvgraft.Error) as caught:
        run(["render", demo / "avatar.glb", "--zoom=0", "-o", tmp_path / "out.png"])
    assert str(caught.value) == "invalid value '0' for '--zoom <FACTOR>': must be 0.1 to 50"


def test_a_missing_file(tmp_path):
    with pytest.raises(FileNotFoundError) as caught:
        run(["render", tmp_path / "none.glb", "-o", tmp_path / "out.png"])
    assert caught.value.filename == str(tmp_path / "none.glb")


def test_a_temporary_folder_is_not_named(tmp_path):
    (tmp_path / "bad.glb").write_bytes(b"nothing")
    with pytest.raises(uvgraft.Error, match=r"^bad\.glb: "):
        run(["render", tmp_path / "bad.glb", "-o", tmp_path / "out.png"], folder=tmp_path)


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("", []),
        ("warning: a\n", [("warning", "a")]),
        ("note: a: b\nwarning: c\n  d\n\nerror: e\n\nf\n", None),
        ("progress\nerror: a", [("error", "a")]),
    ],
)
def test_messages_are_taken_apart(text, wanted):
    if wanted is None:
        wanted = [("note", "a: b"), ("warning", "c\n  d"), ("error", "e\n\nf")]
    assert list(_command._messages(text)) == wanted


def stub(tmp_path, monkeypatch, body):
    """Stand in for the command."""
    script = tmp_path / "stub.py"
    script.write_text(f"import os, sys, time\n{body}\n")
    monkeypatch.setattr(_command, "_program", lambda: [sys.executable, str(script)])


def test_warnings_point_at_the_caller(tmp_path, monkeypatch):
    stub(tmp_path, monkeypatch, "print('warning: one\\nnote: n\\nwarning: two', file=sys.stderr)")
    with pytest.warns(UserWarning) as caught:
        assert run(["x"]).notes == ["n"]
    assert [str(warning.message) for warning in caught] == ["one", "two"]
    assert {warning.filename for warning in caught} == {__file__}


def test_warnings_may_be_errors(tmp_path, monkeypatch):
    stub(tmp_path, monkeypatch, "print('warning: one', file=sys.stderr)")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(UserWarning, match="one"):
            run(["x"])


def test_threads_are_passed_on(tmp_path, monkeypatch):
    stub(tmp_path, monkeypatch, "print(sys.argv[1:])")
    assert run(["x", "y"], threads=3).report == "['x', '--threads=3', 'y']\n"
    before = uvgraft.get_threads()
    uvgraft.set_threads(1)
    try:
        assert "--threads=1" in run(["x"]).report
    finally:
        uvgraft.set_threads(before)


@pytest.mark.parametrize(
    ("body", "kind", "message"),
    [
        ("sys.exit(130)", KeyboardInterrupt, "^$"),
        ("os.kill(os.getpid(), 2); time.sleep(9)", KeyboardInterrupt, "^$"),
        ("os.kill(os.getpid(), 9)", uvgraft.Error, "was ended by signal 9: no message"),
        ("print('thread panicked', file=sys.stderr); sys.exit(101)", uvgraft.Error, "panicked"),
        ("sys.exit('error: a\\nb')", uvgraft.Error, "^a\nb$"),
        (
            "sys.exit('error: cannot read x: y: No such file or directory (os error 2)')",
            FileNotFoundError,
            "y",
        ),
        ("sys.exit('error: d/f: Permission denied (os error 13)')", PermissionError, "d/f"),
    ],
)
def test_other_ends(tmp_path, monkeypatch, body, kind, message):
    stub(tmp_path, monkeypatch, body)
    with pytest.raises(kind, match=message):
        run(["x"])


def test_more_output_than_a_pipe_holds(tmp_path, monkeypatch):
    stub(tmp_path, monkeypatch, "sys.stderr.write('note: ' + 'n' * 999999); print('o' * 999999)")
    report, notes = run(["x"])
    assert (len(report), len(notes[0])) == (1000000, 999999)


def children():
    """Return the processes that this one has started and not waited for."""
    listed = Path(f"/proc/{os.getpid()}/task/{os.getpid()}/children")
    return set(listed.read_text().split())


@pytest.mark.skipif(sys.platform != "linux", reason="needs /proc")
@pytest.mark.parametrize("refuses", [False, True])
def test_an_interruption_ends_the_command(tmp_path, monkeypatch, refuses):
    started = tmp_path / "started"
    ignore = "import signal; signal.signal(signal.SIGTERM, signal.SIG_IGN)" if refuses else ""
    stub(tmp_path, monkeypatch, f"{ignore}\nopen({str(started)!r}, 'w').close()\ntime.sleep(60)")
    monkeypatch.setattr(_command, "_GRACE_S", 0.5)

    def interrupt():
        while not started.exists():
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGINT)

    before = children()
    thread = threading.Thread(target=interrupt)
    thread.start()
    begin = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        run(["x"])
    thread.join()
    assert time.monotonic() - begin < 30
    assert children() == before


def test_an_interpreter_without_a_name(tmp_path, monkeypatch):
    script = tmp_path / "uvgraft"
    script.write_text(f'#!/bin/sh\nexec {sys.executable} -c "print(1234)"\n')
    script.chmod(0o755)
    monkeypatch.setattr("sysconfig.get_path", lambda name: str(tmp_path))
    for executable in (None, "", "/usr/bin/blender"):
        monkeypatch.setattr(sys, "executable", executable)
        assert _command._program() == [str(script)]
        assert run(["x"]).report == "1234\n"


def test_no_interpreter_and_no_script(tmp_path, monkeypatch):
    monkeypatch.setattr("sysconfig.get_path", lambda name: str(tmp_path))
    monkeypatch.setattr(sys, "prefix", str(tmp_path))
    monkeypatch.setattr(sys, "executable", None)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(uvgraft.Error, match="no script `uvgraft` was found"):
        run(["x"])


def test_the_child_imports_what_this_process_does(tmp_path, monkeypatch):
    # Modules in the working directory do not shadow those of the library.
    (tmp_path / "random.py").write_text("raise SystemExit(99)")
    (tmp_path / "uvgraft.py").write_text("raise SystemExit(99)")
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("PYTHONPATH", raising=False)
    assert "uvgraft" in run(["--version"]).report


def test_no_temporary_folder_stays(demo, tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    uvgraft.render(demo / "avatar.glb", size=16)
    with pytest.raises(uvgraft.Error):
        uvgraft.render(demo / "avatar.glb", size=16, expression="none")
    assert list(tmp_path.iterdir()) == []


def test_colours_of_terminals_are_not_in_messages():
    program = """import uvgraft
try:
    uvgraft.render("none.obj", zoom=0)
except uvgraft.Error as error:
    print(ascii(str(error)))
"""
    environment = {**os.environ, "CLICOLOR_FORCE": "1"}
    words = [sys.executable, "-c", program]
    done = subprocess.run(words, capture_output=True, text=True, env=environment, check=True)
    assert done.stdout.startswith('"invalid value')

"""Drivers in processes of their own, and how they are killed."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import uvgraft

HERE = Path(__file__).parent
ENVIRONMENT = {"PYTHONPATH": str(Path(uvgraft.__file__).parent.parent)}
DEADLINE_S = 180


def start(script, *arguments):
    """Start a driver, which prints its reports as one line of JSON."""
    return subprocess.Popen(
        [sys.executable, HERE / script, *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, **ENVIRONMENT},
    )


def reports_of(driver):
    """Wait for a driver and return its reports; None if it failed."""
    out, errors = driver.communicate(timeout=DEADLINE_S)
    if driver.returncode != 0:
        print(errors[-4000:])
        return None
    return json.loads(out.splitlines()[-1])


def wait_for(condition):
    """Wait until a condition holds, and return its value."""
    end = time.monotonic() + DEADLINE_S
    while not (value := condition()):
        assert time.monotonic() < end, "timed out"
        time.sleep(0.02)
    return value


def images(folder):
    """Return the names of the images in a folder."""
    return [name for name in os.listdir(folder) if name.endswith(".png")] if folder.exists() else []


def recorded(folder):
    """Return the names that the records of a folder have, one for each record."""
    lines = (line for path in folder.glob(".uvgraft-manifest*.jsonl") for line in path.open())
    return [json.loads(line)["output"] for line in lines if line.endswith("\n")]


def kill_with_descendants(driver):
    """Kill a driver first, as if its machine was lost, and then what it leaves behind."""
    left = _descendants(driver.pid)
    driver.kill()
    driver.communicate()
    time.sleep(1)
    for pid in left:
        kill(pid)


def kill(pid):
    """Kill a process, if it still exists."""
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        return


def _descendants(pid):
    children = {}
    for entry in Path("/proc").iterdir():
        try:
            stat = (entry / "stat").read_text() if entry.name.isdigit() else ""
        except OSError:
            continue
        if stat:
            parent = int(stat.rpartition(")")[2].split()[1])
            children.setdefault(parent, []).append(int(entry.name))
    found = []
    waiting = [pid]
    while waiting:
        more = children.get(waiting.pop(), [])
        found += more
        waiting += more
    return found

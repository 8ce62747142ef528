"""Results of other implementations, shared with the tests in Rust, and files that scripts fetch."""

import importlib
import json
import os
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
FIXTURES = ROOT / "crates" / "uvgraft-tests" / "fixtures"


def script(name):
    """Import a script that makes the input of a fixture."""
    if str(FIXTURES) not in sys.path:
        sys.path.append(str(FIXTURES))
    return importlib.import_module(name)


def results(name):
    """Read the results of a fixture."""
    return json.loads((FIXTURES / f"{name}.json").read_text())


def download(name):
    """Return the path of a file that a script fetches, or skip the test."""
    folder = os.environ.get("UVGRAFT_TEST_DATA") or ROOT / "target" / "test-data"
    path = Path(folder) / name
    if not path.exists():
        pytest.skip(f"{path} is missing; run scripts/fetch-test-data.sh")
    return path

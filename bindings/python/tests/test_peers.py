"""Files of rarer kinds, compared with what independent readers make of them.

`make test-peers FOLDER=...` does the same with any files.
"""

import os
import subprocess
import sys

import pytest
from peers import report, worker, written_meshes, written_models
from peers.case import check, parameters
from peers.outcome import FAILED, REFUSED, RIGHT, WRONG, Outcome


@pytest.mark.parametrize(
    "case", parameters([*written_meshes.cases(), *written_models.mesh_cases()])
)
def test_meshes(case, tmp_path):
    check("meshes", case, tmp_path)


@pytest.mark.parametrize("case", parameters(written_models.cases()))
def test_models(case, tmp_path):
    check("models", case, tmp_path)


def test_a_report_names_what_is_wrong_and_counts_reasons(tmp_path):
    suite = tmp_path / "suite"
    wrong = Outcome(WRONG, "3 levels at most", 3.0)
    outcomes = [
        ("images", suite / "long_name.png", Outcome(REFUSED, "long_name.png: 16 bits")),
        ("images", suite / "a.png", Outcome(REFUSED, "a.png: 32 bits")),
        ("images", suite / "b.png", wrong),
    ]
    text = report.text(tmp_path, outcomes)
    assert "| suite | images | 3 | 0 | 2 | 0 | 0 | 1 | 0 |" in text
    assert "- wrong: suite/b.png (images, difference 3): 3 levels at most" in text
    assert "- refused, 2 × # bits, such as suite/a.png" in text
    assert report.is_bad(outcomes)
    assert not report.is_bad(outcomes[:2])


def test_a_folder_is_compared_in_other_processes(tmp_path):
    suite = tmp_path / "suite"
    suite.mkdir()
    plain = written_models.cases()[0]
    plain.write(suite / plain.name)
    words = [sys.executable, "-m", "peers", tmp_path, "--jobs", "1"]
    search = os.pathsep.join([os.path.dirname(__file__), *filter(None, sys.path)])
    environment = os.environ | {"PYTHONPATH": search}
    done = subprocess.run(words, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    assert "| suite | meshes | 1 | 1 | 0 |" in done.stdout
    assert "| suite | models | 1 | 1 | 0 |" in done.stdout


def test_a_worker_that_crashes_is_reported_and_replaced(tmp_path):
    case = written_models.cases()[0]
    case.write(tmp_path / case.name)
    a_worker = worker.Worker(limit=60)
    a_worker.run("meshes", tmp_path / case.name)
    a_worker.process.kill()
    assert a_worker.run("meshes", tmp_path / case.name).verdict == FAILED
    assert a_worker.run("meshes", tmp_path / case.name).verdict == RIGHT

"""Textures, and what the command makes of them, for tests of engines."""

import os
import shutil
from pathlib import Path

import numpy as np
import pytest
from processes import ENVIRONMENT
from scenes import command

import uvgraft

GOOD, BAD = 197, ("bad_cut.png", "bad_empty.png", "bad_text.png")


def paint(path, side, seed):
    """Write a texture of smooth colours with a little noise."""
    random = np.random.default_rng(seed)
    waves = np.sin(np.linspace(0, 9 + seed, side))
    picture = 128 + 90 * waves[:, None, None] * waves[None, :, None]
    picture = picture + random.integers(-20, 21, (side, side, 3))
    uvgraft.write_image(path, picture.clip(0, 255).astype(np.uint8))


@pytest.fixture(scope="session")
def faces(tmp_path_factory):
    """A folder of 200 textures, three of which are broken."""
    folder = tmp_path_factory.mktemp("faces")
    for index in range(GOOD):
        paint(folder / f"{index:03}.png", (128, 192, 256)[index % 3], index)
    whole = (folder / "000.png").read_bytes()
    for name, data in zip(BAD, (whole[: len(whole) // 2], b"", b"not an image"), strict=True):
        (folder / name).write_bytes(data)
    return folder


@pytest.fixture(scope="session")
def options(demo):
    """The transfer of all tests."""
    return {
        "pair": str(demo / "head_to_body.uvpair"),
        "onto": str(demo / "body_base.png"),
        "size": 512,
        "blend": "feather",
    }


@pytest.fixture(scope="session")
def wanted(faces, options, tmp_path_factory):
    """What the command writes: bytes by name."""
    folder = tmp_path_factory.mktemp("wanted")
    run_command(faces, options, folder, check=False)
    return contents(folder)


@pytest.fixture(scope="session")
def ray_cluster():
    """Ray with two processors, its workers in processes of their own."""
    ray = pytest.importorskip("ray")
    ray.init(
        num_cpus=2,
        object_store_memory=150 << 20,
        include_dashboard=False,
        log_to_driver=False,
        runtime_env={"env_vars": ENVIRONMENT},
    )
    yield ray
    ray.shutdown()


def run_command(faces, options, folder, *more, check=True):
    """Transfer a folder with the command."""
    return command(
        *("transfer", options["pair"], faces, "--onto", options["onto"], "--size", "512"),
        *("--blend", "feather", "-o", folder, *more),
        check=check,
    )


def contents(folder):
    """Return the images in a folder: bytes by name."""
    folder = Path(folder)
    paths = (path for path in folder.rglob("*") if not path.name.startswith("."))
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in paths
        if path.is_file() and ".uvgraft-manifest" not in path.parts
    }


def check_reports(reports, wanted, status):
    """Check that there is one report for each texture, and that only the broken ones failed."""
    found = {os.path.basename(report["source"]): report for report in reports}
    assert len(found) == len(reports) == GOOD + len(BAD)
    assert {name for name, it in found.items() if it["status"] == status} == set(wanted)
    assert {name for name, it in found.items() if it["status"] == "failed"} == set(BAD)
    for name in BAD:
        assert name in found[name]["error"]


@pytest.fixture
def output(tmp_path):
    """An output folder that does not exist, removed after the test: results are large."""
    yield tmp_path / "bodies"
    shutil.rmtree(tmp_path, ignore_errors=True)

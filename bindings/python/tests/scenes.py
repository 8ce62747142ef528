"""Small meshes and textures, real ones, and the command."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import uvgraft

# One square, laid out upright in one mesh and on its side in the other.
POSITIONS = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
UPRIGHT = [[0.1, 0.1], [0.9, 0.1], [0.9, 0.9], [0.1, 0.9]]
ASIDE = [[0.9, 0.1], [0.9, 0.9], [0.1, 0.9], [0.1, 0.1]]
FACES = [[0, 1, 2], [0, 2, 3]]


def square(uv, name="square"):
    """Make a mesh of two triangles."""
    return uvgraft.Mesh(POSITIONS, FACES, uv, uv_origin="top-left", name=name)


def command(*arguments, check=True):
    """Run the command of this package."""
    words = [sys.executable, "-m", "uvgraft", *map(os.fspath, arguments)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if check and done.returncode != 0:
        raise AssertionError(f"{words}: {done.stderr}")
    return done


def noise(height, width, channels, dtype=np.uint8, seed=1):
    """Make a texture of random values."""
    random = np.random.default_rng(seed)
    if np.dtype(dtype).kind == "f":
        return random.random((height, width, channels), dtype=np.float32)
    return random.integers(0, np.iinfo(dtype).max + 1, (height, width, channels), dtype=dtype)


def real_data():
    """Return the folder of real meshes, or skip the test."""
    folder = os.environ.get("UVGRAFT_DATA")
    if not folder:
        pytest.skip("UVGRAFT_DATA does not name a folder of real meshes")
    return Path(folder)

"""What tests share."""

import pytest
from scenes import ASIDE, UPRIGHT, command, square

import uvgraft


@pytest.fixture(scope="session")
def pair():
    """Two squares, one turned by 90 degrees in its layout."""
    return uvgraft.Pair(square(UPRIGHT, "upright"), square(ASIDE, "aside"), vertex_map=range(4))


@pytest.fixture(scope="session")
def demo(tmp_path_factory):
    """The files of the built-in example."""
    folder = tmp_path_factory.mktemp("demo")
    command("demo", "--size", "256", "-o", folder)
    return folder


@pytest.fixture(scope="session")
def head_to_body(demo):
    """The pair of the built-in example."""
    return uvgraft.Pair.load(demo / "head_to_body.uvpair")


@pytest.fixture(scope="session")
def face(demo):
    """The face of the built-in example."""
    return uvgraft.read_image(demo / "face.png")

"""Seams against differences computed by hand, and the command."""

import json
import pickle

import numpy as np
import pytest
from scenes import POSITIONS, UPRIGHT, command, real_data, square

import uvgraft

GROUPS = [
    "uv_seams",
    "uv_seams_inside",
    "rim",
    "beside_uv_seams",
    "beside_uv_seams_inside",
    "beside_rim",
    "ordinary",
]


def halves(name="halves"):
    """Make a square whose two triangles are islands of their own, left and right."""
    uv = [[0.05, 0.1], [0.45, 0.1], [0.45, 0.9], [0.55, 0.1], [0.95, 0.9], [0.55, 0.9]]
    faces = [[0, 1, 2], [0, 2, 3]]
    return uvgraft.Mesh(POSITIONS, faces, uv, [[0, 1, 2], [3, 4, 5]], uv_origin="top-left")


def lightness(grey):
    """Return L* of CIELAB of a grey in 8 bits."""
    value = grey / 255
    linear = value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
    return 116 * np.cbrt(linear) - 16 if linear > (6 / 29) ** 3 else linear * (29 / 3) ** 3


def delta_e_of_greys(a, b):
    """Return ΔE 2000, which for greys is the difference of L* over its weight S_L."""
    from_50 = ((lightness(a) + lightness(b)) / 2 - 50) ** 2
    weight = 1 + 0.015 * from_50 / np.sqrt(20 + from_50)
    return abs(lightness(a) - lightness(b)) / weight


@pytest.fixture(scope="module")
def split():
    """Link a square with one that has a UV seam along its diagonal."""
    return uvgraft.Pair(square(UPRIGHT), halves(), vertex_map=range(4))


@pytest.mark.parametrize("greys", [(0, 255), (90, 200), (120, 124)])
def test_a_seam_between_two_greys(split, greys):
    texture = np.full((64, 64), greys[0], np.uint8)
    texture[:, 32:] = greys[1]
    found = uvgraft.seams(split, texture)
    wanted = delta_e_of_greys(*greys)
    seam = found.uv_seams
    assert (seam.edges, seam.length) == (1, pytest.approx(np.sqrt(2)))
    for step in seam.delta_e:
        assert step == pytest.approx(wanted, abs=1e-3)
    assert found.uv_seams_inside == seam
    [worst] = found.worst
    assert worst.delta_e == pytest.approx(wanted, abs=1e-3)
    assert worst.edge_mean == pytest.approx(wanted, abs=1e-3)
    assert (worst.is_uv_seam, worst.is_rim) == (True, False)
    assert worst.edge_length == seam.length
    assert sorted(worst.ends) == [(0.0, 0.0, 0.0), (1.0, 1.0, 0.0)]
    for side in range(2):
        grey = greys[worst.sampled_uv[side][0] > 0.5] / 255
        assert worst.colors[side] == pytest.approx((grey,) * 3, abs=1e-6)
        # A texel away, or less where the island ends.
        apart = np.subtract(worst.sampled_uv[side], worst.uv[side]) * 64
        assert 0 < np.hypot(*apart) < 1 + 1e-6
    assert found.worst == sorted(found.worst, key=lambda edge: -edge.edge_mean)
    # Nothing beside the seam to compare with, no region that ends, and no head.
    assert (found.rim.edges, found.rim.delta_e) == (0, None)
    assert found.ordinary.delta_e is None
    assert found.tone is None
    assert found.notes["single_edges"] == 4


def test_the_boundary_of_a_region(pair):
    texture = np.full((64, 64, 3), 100, np.uint8)
    region = uvgraft.Region.vertices([0, 1, 2])
    found = uvgraft.seams(pair, texture, region=region)
    assert (found.rim.edges, found.uv_seams.edges) == (1, 0)
    assert found.rim.delta_e == uvgraft.SeamSteps(0, 0, 0, 0, 0)
    assert found.worst == []
    everything = uvgraft.seams(pair, texture)
    assert (everything.rim.edges, everything.ordinary.edges) == (0, 1)


def test_transparent_sides_are_skipped(split):
    texture = np.full((64, 64, 4), 255, np.uint8)
    texture[:, 32:, 3] = 0
    found = uvgraft.seams(split, texture)
    assert (found.uv_seams.points, found.uv_seams.delta_e) == (0, None)
    assert found.notes["clear"] > 10


def test_pairs_and_grafts(split):
    texture = np.zeros((64, 64), np.uint8)
    texture[:, 32:] = 255
    assert uvgraft.seams(uvgraft.Graft(split), texture) == uvgraft.seams(split, texture)
    # The source has no seam.
    back = uvgraft.seams(uvgraft.Graft(split, reverse=True), texture)
    assert back.uv_seams.edges == 0
    assert back == uvgraft.seams(split, texture, reverse=True)


def from_command(*arguments):
    """Run `uvgraft seams`."""
    return json.loads(command("seams", "--json", *arguments).stdout)


def assert_same(found, wanted):
    """Compare a result with the report of the command."""
    for name in GROUPS:
        group, of_command = getattr(found, name), wanted["edges"][name]
        assert (group.edges, group.points) == (of_command["edges"], of_command["points"])
        assert group.length == of_command["length"]
        steps = None if group.delta_e is None else group.delta_e._asdict()
        assert steps == of_command["delta_e"], name
    assert found.notes == wanted["notes"]
    tone = None if found.tone is None else found.tone._asdict()
    assert tone == wanted["tone"]
    assert len(found.worst) == len(wanted["worst"])
    for edge, of_command in zip(found.worst, wanted["worst"], strict=True):
        values = json.loads(json.dumps(edge._asdict()))
        # The command's triangles are those of a mesh that was cut at the boundary.
        of_command.pop("faces")
        assert values.keys() == of_command.keys()
        for name, value in values.items():
            # The command prints colours and ends in 32 bits.
            np.testing.assert_allclose(value, of_command[name], rtol=1e-6, err_msg=name)


def test_figures_are_those_of_the_command(demo):
    pair, texture = demo / "head_to_body.uvpair", demo / "body_with_face.png"
    base, face = demo / "body_base.png", demo / "face.png"
    loaded = uvgraft.Pair.load(pair)
    found = uvgraft.seams(loaded, texture)
    assert found.uv_seams.edges > 100
    assert found.rim.delta_e.median > 0
    assert len(found.worst) > 5
    assert_same(found, from_command(pair, texture))
    found = uvgraft.seams(loaded, texture, base=base, face=face, distance=0.004, worst=3)
    assert found.tone.own is not None
    assert found.tone.hair_shift is not None
    options = ["--distance", "4mm", "--worst", "3", "--onto", base, "--face", face]
    assert_same(found, from_command(pair, texture, *options))
    back = uvgraft.seams(loaded, uvgraft.read_image(face), reverse=True, offset=2)
    assert_same(back, from_command(pair, face, "--reverse", "--offset", "2"))


def test_real_meshes():
    data = real_data()
    ids = np.load(data / "smplx_flame_vertex_ids.npy")
    names = ("flame_head_template.obj", "smplx_addon.obj")
    pair = uvgraft.Pair(*(data / name for name in names), vertex_map=ids)
    found = uvgraft.seams(pair, data / "body_medium.jpg", worst=0)
    assert found.worst == []
    # A single captured texture: its seams are about as visible as what is beside them.
    assert found.rim.delta_e.median < 2 * found.beside_rim.delta_e.median + 1
    assert found.tone.chest == "chest"
    assert 0 < found.tone.cheek_to_chest < 20


def test_threads_do_not_show(demo):
    pair = uvgraft.Pair.load(demo / "head_to_body.uvpair")
    texture = uvgraft.read_image(demo / "body_with_face.png")
    assert uvgraft.seams(pair, texture, threads=1) == uvgraft.seams(pair, texture, threads=3)


def test_results_can_be_pickled(split):
    found = uvgraft.seams(split, np.arange(64 * 64).reshape(64, 64).astype(np.uint8))
    assert pickle.loads(pickle.dumps(found)) == found


def test_refusals(pair):
    texture = np.zeros((16, 16, 3), np.uint8)
    with pytest.raises(TypeError, match="pair must be a Pair, a path or a Graft, got int"):
        uvgraft.seams(3, texture)
    with pytest.raises(FileNotFoundError, match=r"none\.uvpair"):
        uvgraft.seams("none.uvpair", texture)
    with pytest.raises(ValueError, match="reverse is for a Pair"):
        uvgraft.seams(uvgraft.Graft(pair), texture, reverse=True)
    with pytest.raises(ValueError, match="either offset or distance"):
        uvgraft.seams(pair, texture, offset=1, distance=0.1)
    for bad in (-1, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="offset must be finite and at least 0"):
            uvgraft.seams(pair, texture, offset=bad)
        with pytest.raises(ValueError, match="distance must be finite and at least 0"):
            uvgraft.seams(pair, texture, distance=bad)
    for bad in (-1, 1001):
        with pytest.raises(ValueError, match="worst must be from 0 to 1000"):
            uvgraft.seams(pair, texture, worst=bad)
    with pytest.raises(ValueError, match=r"base must have the height and width of texture, \(16"):
        uvgraft.seams(pair, texture, base=np.zeros((16, 17), np.uint8))
    with pytest.raises(ValueError, match="vertex 9 does not exist"):
        uvgraft.seams(pair, texture, region=uvgraft.Region.vertices([0, 1, 9]))
    with pytest.raises(ValueError, match="region is empty"):
        uvgraft.seams(pair, texture, region=uvgraft.Region.vertices([0]))
    half = uvgraft.Region.vertices([0, 1, 2])
    with pytest.raises(uvgraft.Error, match="region is empty"):
        uvgraft.seams(pair, texture, region=half - half)
    with pytest.raises(FileNotFoundError):
        uvgraft.seams(pair, "nowhere.png")

"""How results look in notebooks."""

import base64
import gzip
import html
import io
import re

import numpy as np
import pytest
from PIL import Image
from scenes import ASIDE, UPRIGHT, noise, square

import uvgraft
from uvgraft import _notebook


def decoded(data):
    """Decode a PNG with another decoder."""
    return np.asarray(Image.open(io.BytesIO(data)))


@pytest.fixture(scope="module")
def avatar(demo):
    """A small avatar."""
    files = [demo / "head_to_body.uvpair", demo / "face.png"]
    return uvgraft.avatar(*files, onto="#c08a70", size=64, body="demo", mouth="none")


def test_pictures_are_pngs():
    for shape in [(1, 1, 3), (5, 7, 3), (40, 3, 3)]:
        picture = noise(*shape)
        assert (decoded(_notebook.png(picture)) == picture).all()


def test_small_textures_are_shown_as_they_are(tmp_path):
    color = noise(20, 30, 3)
    view = uvgraft.show(color)
    assert (decoded(view._repr_png_()) == color).all()
    assert repr(view) == "<uvgraft.TextureView: uint8 (20, 30, 3)>"
    uvgraft.write_image(tmp_path / "a.png", color)
    assert (uvgraft.show(tmp_path / "a.png").picture == color).all()
    assert (uvgraft.show(Image.fromarray(color)).picture == color).all()
    assert (uvgraft.show(color.astype(np.uint16) * 257).picture == color).all()
    assert (uvgraft.show(color / np.float32(255)).picture == color).all()
    assert (uvgraft.show(color / 255.0).picture == color).all()
    grey = uvgraft.show(color[..., 0]).picture
    assert (grey == color[..., :1]).all()
    assert (uvgraft.show(color[..., 0] > 127).picture[..., 0] == 255 * (color[..., 0] > 127)).all()


def test_checks_under_what_is_clear():
    texture = np.zeros((32, 32, 4), np.uint8)
    texture[..., 0] = 200
    texture[:16, :, 3] = 255
    texture[16:24, :, 3] = 51
    picture = uvgraft.show(texture).picture
    assert (picture[:16] == [200, 0, 0]).all()
    assert picture[16, 0].tolist() == [122, 82, 82]
    assert picture[24, 0].tolist() == [153, 153, 153]
    assert picture[24, 8].tolist() == [102, 102, 102]
    with_grey = uvgraft.show(texture[..., [0, 3]]).picture
    assert with_grey[0, 0].tolist() == [200, 200, 200]


def test_large_textures_are_averaged():
    texture = noise(1030, 2051, 3)
    picture = uvgraft.show(texture).picture
    assert picture.shape == (344, 684, 3)
    wanted = texture[3:6, 6:9].mean(axis=(0, 1))
    assert np.abs(picture[1, 2] - wanted).max() <= 0.5
    # The colour of clear texels does not show.
    texture = np.zeros((2048, 4, 4), np.uint8)
    texture[::2] = [255, 255, 255, 0]
    texture[1::2] = [0, 100, 0, 255]
    assert uvgraft.show(texture).picture[0, 0].tolist() == [51, 101, 51]


def test_values_that_are_not_finite_are_magenta():
    texture = np.full((2, 2, 3), 2.0, np.float32)
    texture[0, 0, 1] = np.nan
    texture[1, 1] = -np.inf
    picture = uvgraft.show(texture).picture
    assert picture.tolist() == [[[255, 0, 255], [255] * 3], [[255] * 3, [255, 0, 255]]]


@pytest.mark.parametrize("shape", [(3,), (2, 2, 5), (0, 4), (1, 2, 3, 4)])
def test_other_shapes(shape):
    with pytest.raises(ValueError, match="texture must have shape"):
        uvgraft.show(np.zeros(shape, np.uint8))


@pytest.mark.parametrize("dtype", [np.int64, np.uint32, np.complex64, "U1"])
def test_other_types(dtype):
    with pytest.raises(TypeError, match="texture must have dtype"):
        uvgraft.show(np.zeros((2, 2), dtype))


def panels(picture):
    """Take the two layouts out of the picture of a pair."""
    side, margin = _notebook.PANEL, 12
    return [picture[margin : margin + side, left : left + side] for left in (12, 24 + side)]


def test_both_layouts_have_the_same_colours(pair):
    source, target = panels(decoded(pair._repr_png_()))
    weights = np.random.default_rng(1).dirichlet([2, 2, 2], 200)
    for corners in ([0, 1, 2], [0, 2, 3]):
        at = weights @ np.array(UPRIGHT)[corners]
        # Not at the border of a check, where rounding decides.
        inside = np.abs(at * 16 - np.round(at * 16)).min(axis=1) > 0.15
        there = weights @ np.array(ASIDE)[corners]
        (x, y), (u, v) = ((side[inside] * 512).astype(int).T for side in (at, there))
        assert len(x) > 50
        assert np.abs(source[y, x].astype(int) - target[v, u]).max() <= 3
    # Top left is red, bottom right is green; nothing is in the corners of the layout.
    assert source[80, 80, 0] > source[80, 80, 1] + 40
    assert source[430, 430, 1] > source[430, 430, 0] + 40
    assert (source[10, 10] == _notebook._OUTSIDE).all()
    assert (source[51, 200] == _notebook._BORDER).all()


def test_what_is_not_linked_is_grey(demo):
    pair = uvgraft.Pair.load(demo / "head_to_body.uvpair")
    source, target = panels(_notebook.pair_picture(pair))
    shares = [(panel == _notebook._UNLINKED).all(axis=2).mean() for panel in (source, target)]
    # All of the head is linked, most of the body is not.
    assert shares[0] < 0.01
    assert shares[1] > 0.3


def test_names_of_meshes_are_text():
    pair = uvgraft.Pair(square(UPRIGHT, "<b>&"), square(UPRIGHT), vertex_map=range(4))
    shown = pair._repr_html_()
    assert "&lt;b&gt;&amp; → square</b>: 2 pieces, linked by vertex-map" in shown
    source = re.search(r'src="data:image/png;base64,([^"]+)"', shown)[1]
    assert base64.b64decode(source) == pair._repr_png_()


def test_the_viewer_is_in_a_sandbox():
    page = '<!DOCTYPE html><p title="\'&amp;">Grüße</p>'
    shown = _notebook.viewer_html(page)
    frame = re.fullmatch(r'<iframe srcdoc="([^"]*)" sandbox="([^"]*)" [^<]*></iframe>', shown)
    assert "allow-same-origin" not in frame[2]
    packed = re.search(r'atob\("([^"]+)"\)', html.unescape(frame[1]))[1]
    assert gzip.decompress(base64.b64decode(packed)).decode() == page
    assert shown == _notebook.viewer_html(page)


def test_an_avatar_in_the_viewer(avatar):
    try:
        page = avatar.html()
    except uvgraft.Error as reason:
        if "this build has no viewer" in str(reason):
            pytest.skip(str(reason))
        raise
    assert page.startswith("<!DOCTYPE html>")
    assert "avatar.glb" in page
    shown = avatar._repr_html_()
    assert shown == _notebook.viewer_html(page)
    assert len(shown) <= _notebook.MAX_PAGE_BYTES


def test_an_avatar_that_is_too_large_is_a_picture(avatar, monkeypatch):
    monkeypatch.setattr(uvgraft.Avatar, "html", lambda avatar: noise(1000, 1000, 3).tobytes().hex())
    shown = avatar._repr_html_()
    assert re.search(r"has \d\.\d MB, too much for a notebook; write avatar\.html\(\)", shown)
    source = re.search(r'src="data:image/png;base64,([^"]+)"', shown)[1]
    assert base64.b64decode(source) == avatar._repr_png_()


def test_an_avatar_without_the_viewer_is_a_picture(avatar, monkeypatch):
    def refuse(avatar):
        raise uvgraft.Error("this build has no <viewer>")

    monkeypatch.setattr(uvgraft.Avatar, "html", refuse)
    assert "<small>this build has no &lt;viewer&gt;</small>" in avatar._repr_html_()
    picture = decoded(avatar._repr_png_())
    assert picture.shape == (768, 576, 3)
    # The figure stands in the middle, in front of a background that is not one colour.
    assert np.abs(picture[380, 288].astype(int) - picture[380, 20]).max() > 40


def test_figures_as_tables(demo):
    pair = uvgraft.Pair.load(demo / "head_to_body.uvpair")
    seams = uvgraft.seams(pair, demo / "body_with_face.png", worst=2)
    shown = _notebook.seams_html(seams)
    rows = re.findall(r"<tr>(.*?)</tr>", shown)
    heads = re.findall(r"<th>(.*?)</th>", rows[0])
    assert heads == ["", "edges", "length", "points"] + [
        f"ΔE {name}" for name in ("mean", "median", "p95", "p99", "max")
    ]
    rim = re.findall(r"<td>(.*?)</td>", next(row for row in rows if "<td>rim<" in row))
    assert rim[1] == f"{seams.rim.edges:,}"
    assert rim[5] == f"{seams.rim.delta_e.median:.3g}"
    worst = [row for row in rows if row.startswith(("<td>1</td>", "<td>2</td>"))]
    assert len(worst) == 2
    assert f"<td>{seams.worst[1].edge_mean:.3g}</td>" in worst[1]
    assert f"<td>notes: outside</td><td>{seams.notes['outside']:,}</td>" in shown


def test_figures_that_are_missing():
    steps = uvgraft.SeamSteps(1.0, 2.0, 3.0, 4.0, 5.0)
    some = uvgraft.EdgeGroup(1, 1.5, 1234, steps)
    none = uvgraft.EdgeGroup(0, 0.0, 0, None)
    notes = {"<odd>": 3}
    shown = _notebook.seams_html(
        uvgraft.Seams(some, none, none, none, none, none, none, [], None, notes)
    )
    rows = re.findall(r"<tr>(.*?)</tr>", shown)
    assert re.findall(r"<td>(.*?)</td>", rows[1])[1:] == ["1", "1.5", "1,234", *"12345"]
    assert re.findall(r"<td>(.*?)</td>", rows[2])[1:] == [*"000–––––"]
    assert "<td>tone</td><td>–</td>" in shown
    assert "<td>notes: &lt;odd&gt;</td><td>3</td>" in shown

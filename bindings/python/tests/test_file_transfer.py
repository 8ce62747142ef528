"""Transfers of encoded images give the bytes that the command writes."""

import json
import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from scenes import command, noise

import uvgraft

CASES = [
    ({"onto": "base.png"}, ["--onto", "base.png"], "png"),
    (
        {"onto": "base.png", "blend": "membrane"},
        ["--onto", "base.png", "--blend", "membrane"],
        "png",
    ),
    ({"onto": "#808080", "size": (96, 64)}, ["--onto", "#808080", "--size", "64x96"], "tif"),
    ({"size": 64, "filter": "bilinear"}, ["--size", "64", "--filter", "bilinear"], "webp"),
    ({"onto": "base.png", "quality": 70}, ["--onto", "base.png", "--quality", "70"], "jpg"),
    ({"size": 64, "data": True, "gutter": 3}, ["--size", "64", "--data", "--gutter", "3"], "png"),
    (
        {"onto": "base.png", "fit": True, "fit_steps": 2, "filter": "bilinear"},
        ["--onto", "base.png", "--fit", "--fit-steps", "2", "--filter", "bilinear"],
        "png",
    ),
]


@pytest.fixture
def files(pair, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pair.save("a.uvpair")
    uvgraft.write_image("face.png", noise(48, 48, 3))
    uvgraft.write_image("base.png", noise(64, 64, 3, seed=2))
    return tmp_path


@pytest.mark.parametrize(("options", "arguments", "format"), CASES)
def test_same_bytes_as_the_command(files, options, arguments, format):
    command("transfer", "a.uvpair", "face.png", *arguments, "-o", f"wanted.{format}")
    wanted = (files / f"wanted.{format}").read_bytes()
    transfer = uvgraft.FileTransfer("a.uvpair", **options)
    done = transfer.to_file("face.png", f"found.{format}")
    assert (files / f"found.{format}").read_bytes() == wanted
    assert done.bytes == len(wanted)
    assert (done.height, done.width) == transfer.shape
    data, again = transfer.to_bytes((files / "face.png").read_bytes(), format=format)
    assert data == wanted
    assert again.bytes == done.bytes
    loaded = pickle.loads(pickle.dumps(transfer))
    assert loaded.to_bytes((files / "face.png").read_bytes(), format=format)[0] == wanted


def test_same_bytes_as_arrays(files):
    pair = uvgraft.Pair.load("a.uvpair")
    wanted = uvgraft.Graft(pair, filter="catmull-rom").apply("face.png", "base.png")
    data, _ = uvgraft.FileTransfer("a.uvpair", onto="base.png", filter="catmull-rom").to_bytes(
        (files / "face.png").read_bytes()
    )
    (files / "found.png").write_bytes(data)
    np.testing.assert_array_equal(uvgraft.read_image("found.png"), wanted)


def test_fingerprints_are_those_of_the_command(files):
    (files / "out").mkdir()
    command(
        "transfer", "a.uvpair", "face.png", "--onto", "base.png", "-o", "out/", "--skip-existing"
    )
    record = json.loads((files / "out/.uvgraft-manifest.jsonl").read_text())
    transfer = uvgraft.FileTransfer("a.uvpair", onto="base.png")
    assert transfer.made_from("face.png") in record.values()
    assert transfer.made_from((files / "face.png").read_bytes()) in record.values()
    other = uvgraft.FileTransfer("a.uvpair", onto="base.png", gutter=3)
    assert other.made_from("face.png") not in record.values()
    assert other.fingerprint != transfer.fingerprint


def test_threads_share_it(files):
    transfer = uvgraft.FileTransfer("a.uvpair", onto="base.png", blend="membrane", threads=1)
    faces = []
    for index in range(40):
        path = files / f"face-{index}.png"
        uvgraft.write_image(path, noise(24 + index % 3, 24, 3, seed=index))
        faces.append(path.read_bytes())
    alone = [transfer.to_bytes(face)[0] for face in faces]
    with ThreadPoolExecutor(4) as pool:
        assert [data for data, _ in pool.map(transfer.to_bytes, faces)] == alone


def test_errors(files):
    transfer = uvgraft.FileTransfer("a.uvpair", onto="base.png")
    with pytest.raises(uvgraft.Error, match="row 17"):
        transfer.to_bytes(b"not an image", name="row 17")
    (files / "cut.png").write_bytes((files / "face.png").read_bytes()[:2000])
    (files / "found.png").write_bytes(b"old")
    with pytest.raises(uvgraft.Error, match=r"cut\.png"):
        transfer.to_file("cut.png", "found.png")
    assert (files / "found.png").read_bytes() == b"old"
    with pytest.raises(FileNotFoundError):
        transfer.to_file("none.png", "found.png")
    with pytest.raises(uvgraft.Error, match="folder"):
        transfer.to_file("face.png", "none/found.png")
    with pytest.raises(ValueError, match="format must be one of"):
        transfer.to_bytes(b"", format="bmp")
    for options, message in [
        ({"filter": "cubic"}, "cubic"),
        ({"gutter": -1}, "-1"),
        ({"feather": "10mm", "blend": "none"}, "--feather cannot be used with --blend none"),
        ({"onto": "none.png"}, r"none\.png"),
        ({}, "must have a size"),
        ({"onto": "base.png", "region": "none.npy"}, r"none\.npy"),
    ]:
        with pytest.raises(uvgraft.Error, match=message):
            uvgraft.FileTransfer("a.uvpair", **options)
    with pytest.raises(FileNotFoundError):
        uvgraft.FileTransfer("none.uvpair", size=8)

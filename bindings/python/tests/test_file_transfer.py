"""Transfers of encoded images give the bytes that the command writes."""

import inspect
import json
import pickle
import re
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
    (
        {
            "onto": "base.png",
            "reverse": True,
            "prefer": "right",
            "overlap": "average",
            "linear_light": True,
            "compress": True,
        },
        [
            "--onto",
            "base.png",
            "--reverse",
            "--prefer",
            "right",
            "--overlap",
            "average",
            "--linear-light",
            "--compress",
        ],
        "png",
    ),
    (
        {
            "onto": "base.png",
            "region": ["target:mask.png"],
            "exclude": "corner.npy",
            "unit": "cm",
            "feather": "0.05cm",
            "keep_all": True,
            "source_mask": "mask.png",
            "fill": "face.png",
        },
        [
            "--onto",
            "base.png",
            "--region",
            "target:mask.png",
            "--exclude",
            "corner.npy",
            "--unit",
            "cm",
            "--feather",
            "0.05cm",
            "--keep-all",
            "--source-mask",
            "mask.png",
            "--fill",
            "face.png",
        ],
        "png",
    ),
    (
        {"onto": "base.png", "region": "corner.npy", "grow": "1cm"},
        ["--onto", "base.png", "--region", "corner.npy", "--grow", "1cm"],
        "png",
    ),
    (
        {
            "onto": "base.png",
            "blend": "feather",
            "feather": "10cm",
            "tone": "source",
            "match_skin": True,
            "skin": "mask.png",
            "labels": "labels.png",
        },
        [
            "--onto",
            "base.png",
            "--blend",
            "feather",
            "--feather",
            "10cm",
            "--tone",
            "source",
            "--match",
            "skin",
            "--skin",
            "mask.png",
            "--labels",
            "labels.png",
        ],
        "png",
    ),
]


@pytest.fixture
def files(pair, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    pair.save("a.uvpair")
    uvgraft.write_image("face.png", noise(48, 48, 3))
    uvgraft.write_image("base.png", noise(64, 64, 3, seed=2))
    mask = np.full((32, 32), 255, np.uint8)
    mask[8:24, 12:20] = 0
    uvgraft.write_image("mask.png", mask)
    np.save("corner.npy", np.array([0, 1, 2]))
    # The colour of skin in pictures of labels.
    uvgraft.write_image("labels.png", np.full((48, 48, 3), [222, 165, 138], np.uint8))
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


@pytest.mark.parametrize(("options", "arguments", "format"), CASES)
def test_fingerprints_are_those_of_the_command(files, options, arguments, format):
    (files / "out").mkdir()
    into = ["-o", "out/", "--format", format, "--skip-existing"]
    command("transfer", "a.uvpair", "face.png", *arguments, *into)
    record = json.loads((files / "out/.uvgraft-manifest.jsonl").read_text())
    transfer = uvgraft.FileTransfer("a.uvpair", **options)
    assert transfer.made_from("face.png") in record.values()
    assert transfer.made_from((files / "face.png").read_bytes()) in record.values()
    other = uvgraft.FileTransfer("a.uvpair", **options | {"gutter": 7})
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
    with pytest.raises(uvgraft.Error, match=r"cut\.png"):
        uvgraft.FileTransfer("a.uvpair", onto="cut.png")


@pytest.mark.parametrize(
    ("options", "kind", "message"),
    [
        ({"filter": "cubic"}, uvgraft.Error, '`filter` must be nearest, .* got "cubic"'),
        ({"gutter": -1}, uvgraft.Error, "`gutter` must be a whole number from 0 to 256, got -1"),
        ({"quality": 101}, uvgraft.Error, "`quality` must be a whole number from 1 to 100"),
        (
            {"feather": "10mm", "blend": "none"},
            uvgraft.Error,
            "^`feather` cannot be used with `blend` none$",
        ),
        ({"feather": 10}, uvgraft.Error, '^`feather` "10.0": must have a unit, .* such as 10.0mm'),
        ({"feather": "10"}, uvgraft.Error, '^`feather` "10": must have a unit, .* such as 10mm'),
        ({"grow": -0.02}, uvgraft.Error, '^`grow` "-0.02": must have a unit'),
        ({"size": 8, "grow": "2rings"}, uvgraft.Error, "^`grow` needs `region`"),
        ({"size": 8, "tone": "base"}, uvgraft.Error, "^`tone` needs `blend` membrane"),
        ({}, uvgraft.Error, "must have a size: use `size` N or `onto` IMAGE"),
        ({"size": 8, "data": True, "linear_light": True}, uvgraft.Error, "^`data` cannot be used"),
        ({"size": 8, "fit_steps": 3}, uvgraft.Error, "^`fit_steps` needs `fit`$"),
        ({"size": 8, "fit": True, "filter": "nearest"}, uvgraft.Error, "^`fit` cannot be used"),
        ({"size": 8, "labels": "face.png"}, uvgraft.Error, "^`labels` and `keep_all` need `blend`"),
        ({"size": 8, "region": ""}, uvgraft.Error, "^`region` must be a file"),
        ({"size": 8, "sise": 9}, TypeError, "unexpected keyword argument 'sise'"),
        ({"size": 8, "fit": 1}, TypeError, "fit must be a bool, got int"),
        ({"size": "8"}, TypeError, "size must be a number of texels"),
        ({"onto": 8}, TypeError, "onto must be a NumPy array, a PIL image or a path, got int"),
        ({"size": 8, "threads": -1}, ValueError, "threads must be from 0"),
    ],
)
def test_bad_options(files, options, kind, message):
    with pytest.raises(kind, match=message):
        uvgraft.FileTransfer("a.uvpair", **options)


@pytest.mark.parametrize(
    "options",
    [
        {"onto": "none"},
        {"region": "target:none"},
        {"exclude": ["base.png", "none"]},
        {"blend": "membrane", "tone": "source", "skin": "none"},
        {"blend": "feather", "labels": "none"},
        {"source_mask": "none"},
        {"fill": "none"},
    ],
)
def test_missing_files(files, options):
    with pytest.raises(FileNotFoundError) as caught:
        uvgraft.FileTransfer("a.uvpair", **{"onto": "base.png", **options})
    assert caught.value.filename == "none"
    with pytest.raises(FileNotFoundError):
        uvgraft.FileTransfer("none", size=8)


def test_what_textures_share_is_warned_of(files):
    base = np.full((32, 32, 3), 0.5, np.float32)
    base[3, 4, 0] = np.nan
    uvgraft.write_image("nan.exr", base)
    with pytest.warns(UserWarning, match=r"^nan.exr: 1 texel is NaN or infinite") as caught:
        transfer = uvgraft.FileTransfer(
            "a.uvpair", onto="nan.exr", exclude="corner.npy", feather="1mm"
        )
    assert [it.filename for it in caught] == [__file__]
    assert [note.partition(";")[0] for note in transfer.notes] == ["the mesh has no unit"]
    warnings = transfer.to_bytes((files / "face.png").read_bytes())[1].warnings
    # Nothing of the base again; of the result, whose file cannot hold floats.
    assert len(warnings) == 2
    assert all(warning.startswith("texture: values ") for warning in warnings)


@pytest.mark.parametrize("name", sorted(uvgraft.TransferOptions.__annotations__))
def test_options_of_another_type(files, name):
    given = {"size": 8, "fit": True, name: object()}
    with pytest.raises(TypeError, match=f"^{name} must be"):
        uvgraft.FileTransfer("a.uvpair", **given)
    text = inspect.getdoc(uvgraft.FileTransfer)
    assert re.search(rf"^([\w, ]+, )?{name}(, [\w, ]+)? : ", text, re.M)


def test_arguments_are_shown_and_pickled(files):
    transfer = uvgraft.FileTransfer("a.uvpair", onto="base.png", gutter=0, blend=None)
    wanted = "<uvgraft.FileTransfer: 'a.uvpair', onto='base.png', gutter=0>"
    assert repr(transfer) == wanted
    assert repr(pickle.loads(pickle.dumps(transfer))) == wanted
    assert pickle.loads(pickle.dumps(transfer)).fingerprint == transfer.fingerprint

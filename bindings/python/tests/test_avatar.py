"""Avatars, pictures of them, and textures from photographs."""

import copy
import json
import os
import pickle
import re
import struct
from pathlib import Path

import numpy as np
import pytest
from scenes import command, noise
from uvgraft._command import run

import uvgraft
from uvgraft import _arguments, _avatar, _render, _selfie

DATA = Path(__file__).resolve().parents[3] / "target" / "test-data"


@pytest.fixture(scope="module")
def head_to_body(demo):
    """The pair of the built-in example."""
    return uvgraft.Pair.load(demo / "head_to_body.uvpair")


@pytest.fixture(scope="module")
def face(demo):
    """The face of the built-in example."""
    return uvgraft.read_image(demo / "face.png")


@pytest.fixture(scope="module")
def made(head_to_body, face):
    """An avatar of the built-in figure, of one colour apart from its head."""
    return uvgraft.avatar(head_to_body, face, onto="#c08a70", size=256, body="demo")


def document(data):
    """Read the JSON of a GLB file."""
    length, kind = struct.unpack("<I4s", data[12:20])
    assert kind == b"JSON"
    return json.loads(data[20 : 20 + length])


def test_arrays_and_files_give_the_same_avatar(demo, made, tmp_path):
    files = [demo / "head_to_body.uvpair", demo / "face.png"]
    options = ["--onto=#c08a70", "--size=256", "--body=demo"]
    done = command("avatar", *options, "-o", tmp_path / "avatar.glb", "--", *files)
    assert (tmp_path / "avatar.glb").read_bytes() == made.data
    assert done.stdout.replace(f"{tmp_path}/", "") == made.report
    assert made.report.startswith("body           the demo's figure\n")


def test_textures_of_other_types(demo, head_to_body, face, made):
    wanted = made.render(size=256, camera="head", unlit=True)
    options = {"size": 256, "body": "demo"}
    onto = np.full((256, 256, 3), [0xC0, 0x8A, 0x70], np.uint8)
    floats = face / np.float32(255)
    # A float texture makes a float base, which has no 8 bits to round to in between.
    for given in (floats, face.astype(np.uint16) * 257):
        found = uvgraft.avatar(head_to_body, given, onto=onto, **options)
        assert uvgraft.psnr(wanted, found.render(size=256, camera="head", unlit=True)) > 40
    other = uvgraft.avatar(head_to_body, noise(256, 256, 3), onto=onto, blend="none", **options)
    assert uvgraft.psnr(wanted, other.render(size=256, camera="head", unlit=True)) < 20


def test_materials(head_to_body, face):
    flat = np.full((64, 64, 3), [128, 128, 255], np.uint8)
    rough = np.full((64, 64), 0.25, np.float32)
    avatar = uvgraft.avatar(
        head_to_body,
        face,
        onto="#c08a70",
        size=64,
        body="demo",
        maps={"normal": flat},
        base_maps={"normal": flat, "roughness": rough},
        author=["One", "Two"],
        title="Both",
    )
    found = document(avatar.data)
    assert "normalTexture" in found["materials"][0]
    assert "metallicRoughnessTexture" in found["materials"][0]["pbrMetallicRoughness"]
    assert found["asset"]["extras"] == {"title": "Both", "authors": ["One", "Two"]}


def test_outputs(head_to_body, face, tmp_path):
    options = {"onto": "#c08a70", "size": 64, "body": "demo", "author": "Me"}
    output = tmp_path / "me.vrm"
    avatar = uvgraft.avatar(head_to_body, face, **options, license="everyone", output=output)
    assert output.read_bytes() == avatar.data
    assert document(avatar.data)["extensions"]["VRMC_vrm"]["meta"]["name"] == "me"
    assert list(tmp_path.iterdir()) == [output]
    again = uvgraft.avatar(head_to_body, face, **options, license="everyone", format="vrm")
    assert again.name == "avatar.vrm"
    with pytest.raises(uvgraft.Error, match=r"^avatar\.vrm: a VRM file must name"):
        uvgraft.avatar(head_to_body, face, **options, format="vrm")
    with pytest.raises(FileNotFoundError):
        uvgraft.avatar(head_to_body, tmp_path / "none.png", **options)


def test_levels_of_detail(head_to_body, face, tmp_path):
    try:
        avatar = uvgraft.avatar(head_to_body, face, onto="#888888", size=64, body="demo", lods=2)
    except uvgraft.Error as reason:
        if "needs a build with the feature" in str(reason):
            pytest.skip(str(reason))
        raise
    assert [len(level) < len(avatar.data) for level in avatar.levels] == [True, True]
    avatar.save(tmp_path / "x.glb")
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["x.glb", "x.lod1.glb", "x.lod2.glb"]
    assert (tmp_path / "x.lod2.glb").read_bytes() == avatar.levels[1]
    assert pickle.loads(pickle.dumps(avatar)).levels == avatar.levels


def test_files(made, tmp_path):
    path = tmp_path / "a.GLB"
    made.save(path)
    loaded = uvgraft.Avatar.load(path)
    assert loaded == made
    assert hash(loaded) == hash(made)
    assert (loaded.name, loaded.report, loaded.notes) == ("a.GLB", "", ())
    assert loaded != "avatar"
    assert repr(made).startswith("<uvgraft.Avatar 'avatar.glb': ")
    with pytest.raises(ValueError, match=r"extension must be \.glb"):
        made.save(tmp_path / "a.vrm")
    with pytest.raises(FileNotFoundError, match=r"folder .*none does not exist"):
        made.save(tmp_path / "none" / "a.glb")
    (tmp_path / "b.glb").write_bytes(b"{}")
    with pytest.raises(uvgraft.Error, match=r"b\.glb: must be a GLB or VRM file"):
        uvgraft.Avatar.load(tmp_path / "b.glb")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.GLB", "b.glb"]


def test_pickles(made):
    for again in (pickle.loads(pickle.dumps(made)), copy.deepcopy(made)):
        assert again == made
        assert (again.report, again.name) == (made.report, made.name)


def test_pictures(made, tmp_path):
    rest = made.render(size=(96, 64))
    assert (rest.shape, rest.dtype) == ((96, 64, 3), np.uint8)
    made.save(tmp_path / "a.glb")
    assert (uvgraft.render(tmp_path / "a.glb", size=(96, 64)) == rest).all()
    clear = made.render(size=64, background="transparent")
    assert clear.shape == (64, 64, 4)
    assert (clear[0, 0, 3], clear[32, 32, 3]) == (0, 255)
    red = made.render(size=64, background="#ff0000", unlit=True, floor=False)
    assert red[0, 0].tolist() == [255, 0, 0]


@pytest.mark.parametrize(
    "options",
    [
        {"camera": "head"},
        {"look_at": "leftHand"},
        {"look_at": (-0.2, 1.4, -0.2, 0.2, 1.8, 0.2)},
        {"azimuth": -90},
        {"elevation": np.float32(60)},
        {"fov": 60},
        {"zoom": 2},
        {"pose": "wave"},
        {"pose": {"leftUpperArm": (0, 0, -40)}},
        {"pose": ["a-pose", {"rightUpperArm": (0, 0, 40), "head": np.zeros(3)}]},
        {"clip": "walk", "frame": 0.5},
        {"clip": 2, "frame": 0},
        {"unlit": np.True_},
        {"floor": False},
    ],
)
def test_options_change_pictures(made, options):
    assert (made.render(size=64, **options) != made.render(size=64)).any()


def test_expressions(made):
    def drawn(expression):
        return made.render(size=64, camera="head", expression=expression)

    assert (drawn("jaw_open") == drawn({"jaw_open": 1.0})).all()
    assert (drawn("jaw_open") != drawn({"jaw_open": 0.5})).any()
    assert (drawn(["jaw_open", "smile"]) == drawn({"jaw_open": 1, "smile": 1})).all()


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"expression": "none"}, uvgraft.Error, 'no expression "none"'),
        ({"size": 5000}, uvgraft.Error, "at most 4096"),
        ({"elevation": 90}, uvgraft.Error, "must be -89 to 89"),
        ({"pose": {"head": (0, 1)}}, uvgraft.Error, "BONE=X,Y,Z"),
        ({"look_at": [0, 1, np.nan]}, ValueError, "look_at must be finite"),
    ],
)
def test_bad_pictures(made, options, error, message):
    with pytest.raises(error, match=message):
        made.render(**options)


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"pair": 3}, TypeError, "pair must be a Pair or a path, got int"),
        ({"face": np.zeros((4, 4, 5), np.uint8)}, ValueError, "face must have shape"),
        ({"face": np.zeros((4, 4), np.int64)}, TypeError, "face must have dtype"),
        ({"onto": object()}, TypeError, "onto must be a NumPy array"),
        ({"betas": [[1.0]]}, ValueError, r"betas must be finite, of shape \(n,\)"),
        ({"betas": [1.0]}, uvgraft.Error, "--body demo, whose shape is fixed"),
        ({"size": None}, uvgraft.Error, "--size is required"),
        ({"blend": "glue"}, uvgraft.Error, "invalid value 'glue'"),
    ],
)
def test_bad_arguments(head_to_body, face, options, error, message):
    given = {"pair": head_to_body, "face": face, "onto": "#888888", "size": 64, "body": "demo"}
    with pytest.raises(error, match=message):
        uvgraft.avatar(**{**given, **options})


# Options of the command that are results or arguments here, or concern terminals.
ELSEWHERE = {
    "avatar": {"help", "version", "threads"},
    "selfie": {"help", "version", "threads"},
    "render": {"help", "version", "threads", "print-camera", "turntable", "motion", "fps"},
}


def used(monkeypatch, module, call):
    """Return the names of options that a call passes to the command."""

    class StopError(Exception):
        pass

    words = []

    def record(arguments, **_):
        words.extend(arguments)
        raise StopError

    monkeypatch.setattr(module, "run", record)
    with pytest.raises(StopError):
        call()
    return {word[2:].split("=")[0] for word in words if word.startswith("--")} - {""}


def options_of(subcommand):
    """Return the names of the options of a subcommand."""
    found = re.findall(r"^ +(?:-\w, )?--([a-z-]+)", run([subcommand, "--help"]).report, re.M)
    return set(found) - ELSEWHERE[subcommand]


def test_every_option_of_avatar(monkeypatch, demo):
    image = demo / "face.png"
    options = {
        "motion": "m.npz", "fps": 30, "ground": "clip", "up": "y", "betas": [0.5, -1],
        "shape": {"age": 0.5}, "expressions": "m.npz", "size": (2, 3), "texture_format": "png",
        "quality": 90, "filter": "nearest", "maps": {"normal": image}, "region": "a.npy",
        "exclude": ["b.npy"], "grow": 0.1, "unit": "m", "source_mask": image, "fill": image,
        "preview": "p.png", "blend": "feather", "feather": "5mm", "tone": "base", "skin": image,
        "match_skin": True, "labels": image, "keep_all": True, "lods": 1, "lods_as": "msft",
        "preset": "web", "triangles": 5000, "title": "t", "author": "a", "license": "everyone",
        "license_url": "u", "made_from": "m", "verbose": True,
    }  # fmt: skip
    texture = used(
        monkeypatch, _avatar, lambda: uvgraft.avatar("p", image, onto="b.png", body="x", **options)
    )
    wanted = options_of("avatar")
    photos = {"selfie", "likeness", "face", "focal", "head-texture", "relight", "frames"}
    assert texture == wanted - photos
    of_photos = used(
        monkeypatch,
        _avatar,
        lambda: uvgraft.avatar_from_photos(
            image, body="x", onto="b.png", face_number=1, focal=5, head_texture=image, **options
        ),
    )
    assert of_photos == wanted


def test_every_option_of_render(monkeypatch):
    def call(**aim):
        options = {"pose": "wave", "expression": "a", "clip": 1, "frame": 0, "unlit": True}
        uvgraft.render("a.glb", background="studio", floor=False, **options, **aim)

    found = used(monkeypatch, _render, call)
    found |= used(monkeypatch, _render, lambda: call(look_at="head"))
    assert found == options_of("render")


def test_every_option_of_selfie(monkeypatch):
    def call():
        options = {"face_number": 1, "focal": "28mm", "head_texture": "t.png", "sheet": True}
        uvgraft.selfie("a.jpg", "demo", **options)

    assert used(monkeypatch, _selfie, call) == options_of("selfie")


def test_meshes_become_files_without_loss(demo, tmp_path):
    mesh = uvgraft.Mesh.load(demo / "body.obj")
    _arguments.write_obj(mesh, tmp_path / "mesh.obj")
    again = uvgraft.Mesh.load(tmp_path / "mesh.obj")
    for name in ("positions", "faces", "uv", "uv_faces"):
        assert (getattr(again, name) == getattr(mesh, name)).all(), name


def test_photographs_as_arrays_and_paths(tmp_path):
    one = noise(4, 5, 3)
    arguments = _arguments.Arguments("selfie", tmp_path)
    (path,) = arguments.photographs(one)
    assert (uvgraft.read_image(path) == one).all()
    paths = arguments.photographs([one, "a.jpg", one[..., 0]])
    assert (Path(paths[0]).name, paths[1]) == ("photo1.png", "a.jpg")
    assert len(arguments.photographs(np.stack([one, one]))) == 2
    with pytest.raises(ValueError, match="at least one photograph"):
        arguments.photographs([])


def test_without_the_networks(face, tmp_path, monkeypatch):
    monkeypatch.setenv("UVGRAFT_FACE_WEIGHTS", str(tmp_path / "none"))
    with pytest.raises(uvgraft.Error, match="uvgraft weights import"):
        uvgraft.selfie(face, "demo")


@pytest.fixture(scope="module")
def networks():
    """Find the networks that find faces, or skip the test."""
    path = Path(os.environ.get("UVGRAFT_FACE_WEIGHTS", DATA / "face-networks.safetensors"))
    if not path.is_file():
        pytest.skip("the networks that find faces were not imported")
    return str(path)


def test_photographs(demo, networks, monkeypatch, tmp_path):
    monkeypatch.setenv("UVGRAFT_FACE_WEIGHTS", networks)
    view = {"camera": "head", "elevation": 0, "size": (360, 360)}
    photo = uvgraft.render(demo / "avatar.glb", azimuth=0, **view)
    head = uvgraft.Mesh.load(demo / "head.obj")
    found = uvgraft.selfie(photo, head, size=(128, 256), focal=847, head_texture=demo / "face.png")
    assert found.texture.shape == (128, 256, 3)
    assert found.known.shape == (128, 256)
    assert found.known.max() == 255
    assert found.known.min() == 0
    assert (found.mesh.faces == head.faces).all()
    assert (found.mesh.uv == head.uv).all()
    assert found.cameras["cameras"][0]["size"] == [360, 360]
    assert found.cameras["cameras"][0]["focal_px"] == 847
    assert (".png" in found.report, found.sheet) == (False, None)
    # What the photograph shows has the colours of the face that it shows.
    wanted = uvgraft.read_image(demo / "face.png").reshape(128, 2, 256, 3).mean(axis=1)
    error = np.abs(found.texture - wanted)[found.known > 250].mean()
    assert error < 25, error
    built = uvgraft.avatar_from_photos(photo, body="demo", size=64, mouth="none")
    assert built.report.startswith("head           the demo's head")
    assert built.render(size=32).shape == (32, 32, 3)

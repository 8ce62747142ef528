"""Avatars, pictures of them, and textures from photographs."""

import copy
import json
import os
import pickle
import re
import struct

import numpy as np
import pytest
from references import download
from scenes import command, noise

import uvgraft


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


def recording(path, rate=30.0, **changes):
    """Save a body that walks upright with Y down, as seen by a camera."""
    poses = np.zeros((30, 66), np.float32)
    poses[:, 0] = np.pi
    places = np.zeros((30, 3), np.float32)
    places[:, 2] = 4 - 0.04 * np.arange(30)
    rates = {} if rate is None else {"mocap_framerate": rate}
    np.savez(path, **{"poses": poses, "trans": places, **rates, **changes})
    return path


def test_implausible_motions(head_to_body, face, tmp_path):
    options = {"onto": "#c08a70", "size": 64, "body": "demo", "mouth": "none"}

    def make(changes=None, **more):
        motion = recording(tmp_path / "walk.npz", **(changes or {}))
        return uvgraft.avatar(head_to_body, face, motion=motion, **options, **more)

    assert ", -Y up" in make().report
    assert make(up="-y").data == make().data
    with pytest.warns(UserWarning, match=r"walk\.npz: the body is upside down with Y up; use"):
        make(up="y")
    far = np.arange(90, dtype=np.float32).reshape(30, 3) * 4
    with pytest.warns(UserWarning, match=r"the hips move at \d+ m/s"):
        make({"trans": far})
    with pytest.warns(UserWarning, match=r"not used.* expression \[30, 50\]"):
        make({"expression": np.ones((30, 50))})
    with pytest.raises(uvgraft.Error, match=r"fps.* to state the frame rate of the recording"):
        make({"rate": None})
    made = make({"rate": None}, fps=24)
    assert any("using 24 frames per second" in note for note in made.notes)
    with pytest.raises(uvgraft.Error, match=r"must be y, z, -y or -z, got 'down'|must be .*-y"):
        make(up="down")
    with pytest.raises(uvgraft.Error, match=r"normal_y.* has no effect without a normal map"):
        make(normal_y="directx")


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


def test_pictures_of_meshes_show_textures_side_by_side(demo):
    body, options = demo / "body.obj", {"size": 64, "unlit": True}
    red, blue = (np.full((8, 8, 3), color, np.uint8) for color in ([255, 0, 0], [0, 0, 255]))
    both = uvgraft.render(body, texture=[red, blue], **options)
    assert both.shape == (64, 128, 3)
    assert (both[:, :64] == uvgraft.render(uvgraft.Mesh(body), texture=red, **options)).all()
    assert (both[:, 64:] == uvgraft.render(body, texture=blue, **options)).all()
    assert (both[32, 32] == [255, 0, 0]).all()
    with pytest.raises(uvgraft.Error, match="must be given at most 2 times"):
        uvgraft.render(body, texture=[red] * 3)


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
        ({"pose": {"head": (0, 1)}}, uvgraft.Error, "three angles in degrees for head, got 2"),
        ({"pose": "head=0,1"}, uvgraft.Error, "BONE=X,Y,Z"),
        ({"pose": {"head": (0, 1, np.inf)}}, ValueError, "pose of head must be finite"),
        ({"zoom": 0}, uvgraft.Error, "^`zoom` must be 0.1 to 50, got 0$"),
        ({"look_at": (0, 1, 2)}, uvgraft.Error, "`look_at` must be six numbers"),
        ({"camera": "feet"}, uvgraft.Error, '`camera` must be body or head, got "feet"'),
        ({"expression": {"smile": np.nan}}, ValueError, "smile"),
        ({"background": "red"}, uvgraft.Error, "`background` .*must be studio, transparent"),
        ({"clip": 99}, uvgraft.Error, 'no clip "99"'),
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
        ({"betas": [1.0]}, uvgraft.Error, "`betas` cannot be used with `body` demo"),
        ({"size": None}, uvgraft.Error, "^`size` is required where `onto` is a colour$"),
        ({"size": 0}, uvgraft.Error, "`size` must be 1 to 32768 texels a side, got 0"),
        ({"size": (1, 2, 3)}, TypeError, r"size must be a number of texels or \(height, width\)"),
        ({"blend": "glue"}, uvgraft.Error, '`blend` must be none, feather or membrane, got "glue"'),
        (
            {"feather": "wide"},
            uvgraft.Error,
            '`feather` "wide": must be a number with a unit, such as 15mm',
        ),
        ({"grow": "2 steps"}, uvgraft.Error, "`grow` .*or rings, such as 2rings"),
        ({"onto": "#12"}, uvgraft.Error, '^`onto`: colour must be #RGB.*, got "#12"'),
        ({"gutter": -1}, uvgraft.Error, "`gutter` must be a whole number from 0 to 256, got -1"),
        ({"lods": 0}, uvgraft.Error, "`lods` must be a whole number from 1"),
        ({"fps": 29.97, "motion": "a"}, uvgraft.Error, "`fps` must be a whole number .* got 29.97"),
        ({"fps": 30}, uvgraft.Error, "`fps` needs `motion`"),
        ({"lods_as": "msft"}, uvgraft.Error, "`lods_as` needs `lods`"),
        ({"preset": "moon"}, uvgraft.Error, "`preset` must be one of quest, pcvr"),
        ({"license": "free"}, uvgraft.Error, "`license` must be one of only-author"),
        ({"license": "everyone"}, uvgraft.Error, r"^`license` is for \.vrm outputs only"),
        ({"skin": noise(4, 4, 1), "tone": "base"}, uvgraft.Error, "^`skin` needs `tone` source"),
        ({"maps": [1]}, TypeError, "maps must be a mapping of roles to images, got list"),
        ({"maps": {"gloss": "a.png"}}, uvgraft.Error, "`maps` must have roles"),
        ({"maps": {"ao": "a", "occlusion": "b"}}, uvgraft.Error, "`maps` has the role occlusion"),
        (
            {"maps": {"orm": noise(4, 4, 3), "roughness": noise(4, 4, 1)}},
            uvgraft.Error,
            "^`maps` orm cannot be used with `maps` occlusion, roughness or metallic",
        ),
        ({"shape": {"age": 0.5}, "betas": [1.0]}, uvgraft.Error, "cannot be used with `body` demo"),
    ],
)
def test_bad_arguments(head_to_body, face, options, error, message):
    given = {"pair": head_to_body, "face": face, "onto": "#888888", "size": 64, "body": "demo"}
    with pytest.raises(error, match=message):
        uvgraft.avatar(**{**given, **options})


def test_missing_files(demo, tmp_path):
    none = tmp_path / "none.png"
    files = (demo / "head_to_body.uvpair", demo / "face.png")
    given = {"onto": "#888888", "size": 64, "body": "demo"}

    def check(call):
        with pytest.raises(FileNotFoundError) as caught:
            call()
        assert caught.value.filename == str(none)

    check(lambda: uvgraft.avatar(none, files[1], **given))
    check(lambda: uvgraft.avatar(files[0], none, **given))
    for options in [
        {"onto": none},
        {"body": none},
        {"motion": [none]},
        {"betas": none, "body": none},
        {"expressions": none},
        {"maps": {"normal": none}},
        {"base_maps": {"normal": none}},
        {"region": f"target:{none}"},
        {"exclude": none},
        {"source_mask": none},
        {"fill": none},
        {"skin": none},
    ]:
        check(lambda options=options: uvgraft.avatar(*files, **{**given, **options}))
    check(lambda: uvgraft.avatar_from_photos(none, body="demo"))
    check(lambda: uvgraft.avatar_from_photos([files[1], none], body="demo"))
    check(lambda: uvgraft.avatar_from_photos(files[1], body="demo", head_texture=none))
    check(lambda: uvgraft.selfie(none, "demo"))
    check(lambda: uvgraft.selfie(files[1], none))
    check(lambda: uvgraft.selfie(files[1], "demo", head_texture=none))
    check(lambda: uvgraft.render(none))
    beside = demo / "face.png" / "below.glb"
    with pytest.raises(NotADirectoryError) as caught:
        uvgraft.render(beside)
    assert caught.value.filename == str(beside)
    if os.geteuid() != 0:
        none.touch(0)
        with pytest.raises(PermissionError):
            uvgraft.selfie(none, "demo")


def test_outputs_are_checked_first(demo, tmp_path):
    files = (demo / "head_to_body.uvpair", demo / "face.png")
    given = {"onto": "#888888", "size": 64, "body": "demo"}
    with pytest.raises(FileNotFoundError, match=r"folder .*none does not exist"):
        uvgraft.avatar(*files, **given, output=tmp_path / "none" / "a.glb")
    for options, message in [
        ({"output": tmp_path / "a.obj"}, r"^a\.obj: extension must be \.glb or \.vrm"),
        ({"preview": tmp_path / "none" / "a.png"}, "folder .*none does not exist"),
        ({"preview": tmp_path / "a.txt"}, "a preview must be an image"),
        ({"labels": tmp_path / "a.txt"}, "a label image must be an image"),
        ({"preview": files[1]}, "is also an input"),
    ]:
        with pytest.raises(uvgraft.Error, match=message):
            uvgraft.avatar(*files, **given, **options)
    assert list(tmp_path.iterdir()) == []


def test_messages_name_files_and_arguments(demo, head_to_body, tmp_path):
    bad = tmp_path / "bad.glb"
    bad.write_bytes(b"nothing")
    with pytest.raises(uvgraft.Error, match=rf"^{re.escape(str(bad))}: not a glTF file"):
        uvgraft.render(bad)
    with pytest.raises(uvgraft.Error, match=r"^'?pair'?: "):
        mesh = head_to_body.source
        pair = uvgraft.Pair(mesh, mesh)
        uvgraft.avatar(pair, demo / "face.png", onto="#888", size=64, body="demo")
    with pytest.raises(TypeError, match="avatar must be an Avatar, a Mesh or a path, got int"):
        uvgraft.render(3)


def test_memory_is_bounded(demo):
    path = demo / "avatar.glb"
    with pytest.raises(uvgraft.Error, match=r"avatar\.glb: may take .* but `memory` allows 2"):
        uvgraft.render(path, size=16, memory="2M")
    with pytest.raises(uvgraft.Error, match="`memory` must be a size such as 500M or 4G, got x"):
        uvgraft.render(path, size=16, memory="x")
    assert (uvgraft.render(path, size=16, memory=8 << 30) == uvgraft.render(path, size=16)).all()


def test_photographs_as_arrays_and_paths(demo, tmp_path, monkeypatch):
    monkeypatch.setenv("UVGRAFT_FACE_WEIGHTS", str(tmp_path / "none"))
    one = noise(4, 5, 3)
    for photos in (one, [one, demo / "face.png", one[..., 0]], np.stack([one, one])):
        with pytest.raises(uvgraft.Error, match="networks that find faces"):
            uvgraft.selfie(photos, "demo")
    with pytest.raises(ValueError, match="at least one photograph"):
        uvgraft.selfie([], "demo")
    with pytest.raises(ValueError, match=r"photos\[1\] must have shape"):
        uvgraft.selfie([one, noise(4, 5, 3)[0, 0]], "demo")
    with pytest.raises(TypeError, match="photos must be an image"):
        uvgraft.selfie(3, "demo")
    with pytest.raises(uvgraft.Error, match="must be at most 64 photographs, got 65"):
        uvgraft.selfie([one] * 65, "demo")


def test_without_the_networks(face, tmp_path, monkeypatch):
    monkeypatch.setenv("UVGRAFT_FACE_WEIGHTS", str(tmp_path / "none"))
    with pytest.raises(uvgraft.Error, match="uvgraft weights import"):
        uvgraft.selfie(face, "demo")


@pytest.fixture(scope="module")
def networks(tmp_path_factory):
    """Import the networks that find faces, or skip the test."""
    package = download("mediapipe-face_mesh-0.4.1657299874.tgz")
    path = tmp_path_factory.mktemp("networks") / "face.safetensors"
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("UVGRAFT_FACE_WEIGHTS", str(path))
        command("weights", "import", package)
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

"""Options of avatars, heads, pictures and transfers: those of the command, with the same effect."""

import inspect
import pydoc
import re
import warnings

import numpy as np
import pytest
from scenes import command, noise

import uvgraft


@pytest.mark.parametrize("name", sorted(uvgraft.AvatarOptions.__annotations__))
def test_options_of_another_type(demo, name):
    """Each option is taken, since a value of another type is refused by its name."""
    files = (demo / "head_to_body.uvpair", demo / "face.png")
    given = {"onto": "#888888", "size": 64, "body": "demo", "motion": "m.npz", "lods": 1}
    with pytest.raises(TypeError) as caught:
        uvgraft.avatar(*files, **{**given, name: object()})
    # A path in Python, before the rest is looked at.
    wanted = "argument should be a str or an os.PathLike" if name == "output" else f"{name} must "
    assert wanted in str(caught.value)


def test_unknown_options(head_to_body, face):
    given = {"onto": "#888888", "body": "demo"}
    # Of photographs, of the function itself, and of nothing.
    for name in ("likeness", "photos", "sise"):
        with pytest.raises(TypeError, match=f"avatar.* unexpected keyword argument '{name}'"):
            uvgraft.avatar(head_to_body, face, **given, **{name: 1})
    with pytest.raises(TypeError, match=r"avatar_from_photos.* argument 'face'"):
        uvgraft.avatar_from_photos(face, body="demo", face=face)
    with pytest.raises(TypeError, match=r"missing .* 'onto'"):
        uvgraft.avatar(head_to_body, face, body="demo")


def test_help_lists_all_options():
    text = pydoc.render_doc(uvgraft.avatar, renderer=pydoc.plaintext)
    for name in uvgraft.AvatarOptions.__annotations__:
        assert re.search(rf"^ +([\w, ]+, )?{name}(, [\w, ]+)? : .+\n +\w", text, re.M), name


# Options of the command, and the parameters that stand for them where names differ; None for what
# is a result here, or concerns terminals.
ELSEWHERE = {"help": None, "version": None, "json": None, "quiet": None, "threads": "threads"}
PARAMETERS = {
    "avatar": {
        "face": "face_number",
        "map": "maps",
        "match": "match_skin",
        "selfie": "photos",
        "texture": "texture_format",
    },
    "selfie": {
        "cameras": None,
        "face": "face_number",
        "known": None,
        "mesh": None,
        "output": None,
    },
    "render": {
        "fps": None,
        "motion": None,
        "no-floor": "floor",
        "output": None,
        "print-camera": None,
        "turntable": None,
    },
    "transfer": {
        "format": None,
        "jobs": None,
        "manifest": None,
        "map": None,
        "mask": None,
        "match": "match_skin",
        "memory": None,
        "normal-y": None,
        "normal-y-out": None,
        "output": None,
        "preview": None,
        "report": None,
        "shard": None,
        "skip-existing": None,
        "with-map": None,
    },
}


def options_of(subcommand):
    """Return the names of the options of a subcommand."""
    return set(re.findall(r"^ +(?:-\w, )?--([a-z-]+)", command(subcommand, "--help").stdout, re.M))


def parameters_of(*functions):
    """Return the names of the parameters of functions, those of their options included."""
    names = set()
    for function in functions:
        for name, parameter in inspect.signature(function).parameters.items():
            if parameter.kind is not inspect.Parameter.VAR_KEYWORD:
                names.add(name)
            else:
                options = re.fullmatch(r"Unpack\[(\w+)\]", parameter.annotation)[1]
                names |= getattr(uvgraft, options).__annotations__.keys()
    return names


@pytest.mark.parametrize(
    ("subcommand", "functions", "arguments"),
    [
        (
            "avatar",
            [uvgraft.avatar, uvgraft.avatar_from_photos],
            # Bases of maps are a role in an option; a format is part of an output's name.
            {"pair", "face", "base_maps", "format"},
        ),
        ("selfie", [uvgraft.selfie], {"photos"}),
        ("render", [uvgraft.render], {"avatar"}),
        ("transfer", [uvgraft.FileTransfer], {"pair"}),
    ],
)
def test_every_option_of_the_command(subcommand, functions, arguments):
    others = ELSEWHERE | PARAMETERS[subcommand]
    options = options_of(subcommand)
    assert others.keys() <= options
    wanted = {others.get(option, option.replace("-", "_")) for option in options} - {None}
    assert parameters_of(*functions) == wanted | arguments


# For each option of the command's avatars a value, as the command and as Python take it.
def compared(demo, tmp_path):
    """Return options that change an avatar, as words and as arguments."""
    image = demo / "face.png"
    flat, rough = tmp_path / "flat.png", tmp_path / "rough.png"
    uvgraft.write_image(flat, np.full((8, 8, 3), [128, 140, 250], np.uint8))
    uvgraft.write_image(rough, noise(32, 32, 1))
    ids = tmp_path / "ids.npy"
    np.save(ids, np.arange(900))
    return [
        (
            ["--texture=jpeg", "--quality=70", "--filter=bilinear", "--gutter=3", "--prefer=left"],
            {
                "texture_format": "jpeg",
                "quality": 70,
                "filter": "bilinear",
                "gutter": 3,
                "prefer": "left",
            },
        ),
        (
            [f"--region={ids}", "--grow=5mm", "--unit=m", "--blend=feather", "--feather=4mm"],
            {"region": ids, "grow": "5mm", "unit": "m", "blend": "feather", "feather": "4mm"},
        ),
        (
            [f"--exclude={ids}", "--grow=-2mm", "--feather=0.004m", "--tone=both", "--match=skin"],
            {
                "exclude": [ids],
                "grow": "-2mm",
                "feather": "0.004m",
                "tone": "both",
                "match_skin": True,
            },
        ),
        (
            [
                f"--map=normal={flat}",
                f"--onto=roughness={rough}",
                "--onto=ao=#808080",
                "--normal-y=directx",
                "--texture-layout=head+body",
            ],
            {
                "maps": {"normal": uvgraft.read_image(flat)},
                "base_maps": {"roughness": uvgraft.read_image(rough), "ao": "#808080"},
                "normal_y": "directx",
                "texture_layout": "head+body",
            },
        ),
        (
            [f"--fill={image}", f"--source-mask={rough}", f"--skin={rough}", "--keep-all"],
            {
                "fill": uvgraft.read_image(image),
                "source_mask": uvgraft.read_image(rough),
                "skin": uvgraft.read_image(rough),
                "keep_all": True,
            },
        ),
        (
            [
                "--mouth=none",
                "--eyes=clean",
                "--preset=web",
                "--title=Me",
                "--author=A",
                "--author=B",
                "--look=unlit",
            ],
            {
                "mouth": "none",
                "eyes": "clean",
                "preset": "web",
                "title": "Me",
                "author": ["A", "B"],
                "look": "unlit",
            },
        ),
    ]


@pytest.mark.parametrize("case", range(6))
def test_options_mean_what_those_of_the_command_do(demo, head_to_body, face, tmp_path, case):
    words, options = compared(demo, tmp_path)[case]
    common = ["--onto=#c08a70", "--size=64", "--body=demo", *words]
    files = [demo / "head_to_body.uvpair", demo / "face.png"]
    done = command("avatar", *common, "-o", tmp_path / "avatar.glb", "--", *files, check=False)
    given = {"onto": "#c08a70", "size": 64, "body": "demo", **options}
    if "feature `simplify`" in done.stderr:
        pytest.skip(done.stderr)
    assert done.returncode == 0, done.stderr
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        made = uvgraft.avatar(head_to_body, face, **given)
    assert made.data == (tmp_path / "avatar.glb").read_bytes()
    assert made.report == done.stdout.replace(f"{tmp_path}/", "")
    plain = uvgraft.avatar(head_to_body, face, onto="#c08a70", size=64, body="demo")
    assert made.data != plain.data


def test_vrm_and_drawings(demo, head_to_body, face, tmp_path):
    words = ["--onto=#c08a70", "--size=64", "--body=demo", "--author=A", "--license=everyone"]
    words += ["--license-url=https://example.org", "--made-from=this", "--look=mtoon"]
    drawings = [f"--preview={tmp_path / 'p.png'}", f"--labels={tmp_path / 'l.png'}"]
    files = [demo / "head_to_body.uvpair", demo / "face.png"]
    command("avatar", *words, *drawings, "-o", tmp_path / "avatar.vrm", "--", *files)
    again = tmp_path / "again"
    again.mkdir()
    made = uvgraft.avatar(
        head_to_body,
        face,
        onto="#c08a70",
        size=64,
        body="demo",
        author="A",
        license="everyone",
        license_url="https://example.org",
        made_from="this",
        look="mtoon",
        preview=again / "p.png",
        labels=again / "l.png",
        output=again / "avatar.vrm",
    )
    for name in ("avatar.vrm", "p.png", "l.png"):
        assert (again / name).read_bytes() == (tmp_path / name).read_bytes(), name
    assert made.data == (again / "avatar.vrm").read_bytes()
    # Labels that exist are read.
    options = {"onto": "#c08a70", "size": 64, "body": "demo"}
    drawn = uvgraft.avatar(head_to_body, face, **options, labels=again / "l.png")
    assert drawn == uvgraft.avatar(head_to_body, face, **options)


def test_pictures_are_those_of_the_command(demo, tmp_path):
    path = demo / "avatar.glb"
    words = ["--size=64x96", "--look-at=leftHand", "--azimuth=-30", "--elevation=12.5", "--fov=40"]
    words += ["--zoom=0.8", "--pose=wave", "--pose=head=0,10,-5", "--expression=smile=0.7"]
    words += ["--clip=walk", "--frame=0.5", "--background=#204060", "--no-floor"]
    command("render", *words, "-o", tmp_path / "a.png", path)
    drawn = uvgraft.render(
        path,
        size=(96, 64),
        look_at="leftHand",
        azimuth=-30,
        elevation=12.5,
        fov=40,
        zoom=0.8,
        pose=["wave", {"head": (0, 10, -5)}],
        expression={"smile": 0.7},
        clip="walk",
        frame=0.5,
        background="#204060",
        floor=False,
    )
    np.testing.assert_array_equal(drawn, uvgraft.read_image(tmp_path / "a.png"))

"""The examples run, and do what they say."""

import importlib.util
import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from scenes import noise

import uvgraft

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"
pytestmark = pytest.mark.skipif(not EXAMPLES.is_dir(), reason="no examples beside the tests")


def example(name):
    """Import an example."""
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.filterwarnings("ignore:matching the tone makes:UserWarning")
def test_a_head_onto_a_body_with_files(demo, tmp_path):
    output = tmp_path / "out.png"
    names = ["head.obj", "body.obj", "face.png", "body_darker.png"]
    files = [str(demo / name) for name in names]
    table = ["--vertex-map", str(demo / "head_to_body.npy")]
    before, after = example("flame_to_smplx").main([*files, *table, "-o", str(output)])
    assert after.median < before.median / 3
    texture, base = uvgraft.read_image(output), uvgraft.read_image(files[3])
    assert texture.shape == base.shape
    assert (texture != base).any(axis=2).mean() > 0.1


def test_a_head_onto_a_body_without_files(demo, tmp_path, monkeypatch):
    output = tmp_path / "out.png"
    module = example("flame_to_smplx")
    commands = []

    def run(words, **_):
        commands.append(words[1:4])
        shutil.copytree(demo, words[-1], dirs_exist_ok=True)

    monkeypatch.setattr(module.subprocess, "run", run)
    module.main(["-o", str(output)])
    assert commands == [["-m", "uvgraft", "demo"]]
    assert uvgraft.read_image(output).shape == (256, 256, 3)


def workspace(folder, face, opacity):
    """Make a minimal workspace of FATE: pictures of what it baked."""
    baked = folder / "workspace" / "baking" / "visualize_texture"
    baked.mkdir(parents=True)
    # Pictures show coefficients of a constant harmonic from -1.78 to 1.78.
    values = (face[..., :3] / 255 - 0.5) / 0.2820948
    picture = np.rint((values / 1.78 + 1) / 2 * 255).clip(0, 255).astype(np.uint8)
    uvgraft.write_image(baked / "020000_color.png", picture)
    uvgraft.write_image(baked / "020000_opacity.png", opacity)
    return folder / "workspace"


def test_a_fate_workspace_as_an_avatar(demo, tmp_path):
    face = uvgraft.read_image(demo / "face.png")
    folder = workspace(tmp_path, face, np.full(face.shape[:2], 255, np.uint8))
    output = tmp_path / "me.glb"
    files = [demo / "head_to_body.uvpair", demo / "body_base.png"]
    words = [str(folder), *map(str, files), "demo", "-o", str(output)]
    avatar = example("fate_to_glb").main(words)
    assert uvgraft.Avatar.load(output) == avatar
    picture = uvgraft.read_image(output.with_suffix(".png"))
    # The same face as an image looks the same, apart from FATE's 8 bits and corners.
    direct = uvgraft.avatar(files[0], face, onto=files[1], body="demo", tone="source")
    wanted = direct.render(camera="head", size=(512, 512))
    assert uvgraft.psnr(wanted, picture) > 30
    other = uvgraft.avatar(files[0], noise(256, 256, 3), onto=files[1], body="demo", blend="none")
    strange = other.render(camera="head", size=(512, 512))
    assert uvgraft.psnr(wanted, strange) < 25


def notebook(path):
    """The code of a notebook's cells, and what is kept of an earlier run."""
    cells = json.loads(path.read_text())["cells"]
    code = [cell for cell in cells if cell["cell_type"] == "code"]
    kept = [cell for cell in code if cell["outputs"] or cell["execution_count"]]
    return ["".join(cell["source"]) for cell in code], kept


def test_the_notebook_runs_from_top_to_bottom(demo, tmp_path, monkeypatch):
    cells, kept = notebook(EXAMPLES / "face_to_body.ipynb")
    assert not kept, "outputs of notebooks are not committed"
    monkeypatch.chdir(tmp_path)
    # The built-in example is there already; the command itself takes longer.
    commands = []

    def run(words, **_):
        commands.append(words[1:4])
        shutil.copytree(demo, words[-1])

    monkeypatch.setattr(subprocess, "run", run)
    names = {}
    for cell in cells:
        exec(cell, names)
    assert commands == [["-m", "uvgraft", "demo"]]
    assert names["blended"].shape == names["pasted"].shape == names["darker"].shape
    assert names["steps"]["blended"] < names["steps"]["pasted"] / 3
    assert uvgraft.Avatar.load(tmp_path / "me.glb") == names["avatar"]

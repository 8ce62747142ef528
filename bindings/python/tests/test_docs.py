"""The examples of the book run as they are written, on the files of the built-in example."""

import re
import shutil
import textwrap
from pathlib import Path

import pytest
from scenes import noise

import uvgraft

BOOK = Path(__file__).resolve().parents[3] / "docs" / "src"
NAMES = {"head_to_body.npy": "ids.npy", "body_base.png": "body.png"}


@pytest.mark.skipif(not BOOK.is_dir(), reason="the book is not beside the tests")
def test_the_page_on_python(demo, tmp_path, monkeypatch):
    for path in demo.iterdir():
        shutil.copy(path, tmp_path / NAMES.get(path.name, path.name))
    monkeypatch.chdir(tmp_path)
    text = (BOOK / "python.md").read_text()
    blocks = re.findall(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    assert len(blocks) >= 4
    names = {}
    for block in blocks:
        exec(compile(block, "python.md", "exec"), names)
    assert uvgraft.read_image("body_with_face.png").shape == names["body"].shape


def test_the_example_in_the_package(demo, tmp_path, monkeypatch):
    for path in demo.iterdir():
        shutil.copy(path, tmp_path / NAMES.get(path.name, path.name))
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"::\n\n((?:    .+\n|\n)+)", uvgraft.__doc__)
    assert len(blocks) == 2
    for block in blocks:
        exec(compile(textwrap.dedent(block), "__init__.py", "exec"), {"uvgraft": uvgraft})
    assert uvgraft.read_image("body_with_face.png").size > noise(1, 1, 3).size

"""What libraries say to Python's users has the names that arguments have in Python."""

import inspect
import re
from pathlib import Path

import pytest
from references import ROOT

import uvgraft

# What libraries call otherwise; `src/error.rs` has the same table.
RENAMED = {"map": "maps"}
# Options of the command alone: no call from Python leads to a message that names them.
UNREACHABLE = {
    "manifest",
    "mask",
    "shard",
    "skip_existing",
    "with_map",
}
# Of what else is in backticks: features of the build, and what is in files.
OTHERS = {"ktx2", "simplify"}
SOURCES = ["uvgraft-assembly", "uvgraft-pipeline"]


def messages():
    """Yield the strings of two libraries, and where they are, without those of tests."""
    for crate in SOURCES:
        for path in sorted((ROOT / "crates" / crate / "src").rglob("*.rs")):
            if path.stem.endswith("tests"):
                continue
            text = path.read_text().split("#[cfg(test)]")[0]
            code = re.sub(r"^\s*//.*$", "", text, flags=re.M)
            for string in re.findall(r'"((?:[^"\\]|\\.)*)"', code, re.S):
                yield path, string


def parameters():
    """Return the names of all parameters of the functions that run requests, and of a pair's."""
    functions = [
        uvgraft.Pair,
        uvgraft.avatar,
        uvgraft.avatar_from_photos,
        uvgraft.selfie,
        uvgraft.render,
        uvgraft.FileTransfer,
        uvgraft.FileTransfer.to_bytes,
    ]
    names = {name for function in functions for name in inspect.signature(function).parameters}
    names |= uvgraft.AvatarOptions.__annotations__.keys()
    return names | uvgraft.TransferOptions.__annotations__.keys()


@pytest.mark.skipif(not Path(ROOT, "crates").is_dir(), reason="needs the sources")
def test_messages_name_parameters():
    named = {}
    for path, string in messages():
        for name in re.findall(r"`([a-z0-9_]+)`", string):
            named.setdefault(RENAMED.get(name, name), path.name)
        # Commands have options.
        text = re.sub(r"`[^`]* [^`]*`|cargo install .*", "", string)
        assert not re.search(r"(?<![\w`-])--[a-z]", text), path
    assert len(named) > 40
    unknown = named.keys() - parameters() - UNREACHABLE - OTHERS
    assert not unknown, {name: named[name] for name in unknown}
    # Neither list says more than it has to.
    assert named.keys() >= UNREACHABLE | OTHERS
    assert not UNREACHABLE & parameters()

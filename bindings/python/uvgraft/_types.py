"""Types of arguments that several functions take.

The names of values are those of the compiled part; a test compares them.
"""

from __future__ import annotations

import os
from typing import Any, Literal, TypeAlias, TypedDict

StrPath: TypeAlias = str | os.PathLike[str]
# An array, a PIL image, anything else with `__array__`, or the path of an image file.
Image: TypeAlias = Any
# An image, a list of these, or an array of shape (n, height, width, channels).
Images: TypeAlias = Any
# A `Mesh`, a path, or an object with `vertices`, `faces` and `visual.uv`, such as trimesh's.
MeshLike: TypeAlias = Any
Size: TypeAlias = int | tuple[int, int]

BlendMode = Literal["none", "feather", "membrane"]
Filter = Literal["nearest", "bilinear", "catmull-rom", "lanczos3"]
NormalY = Literal["opengl", "directx"]
Overlap = Literal["first", "average"]
Prefer = Literal["first", "left", "right"]
Relight = Literal["off", "soft", "full"]
Role = Literal["normal", "roughness", "metallic", "occlusion", "orm", "emissive"]
Side = Literal["source", "target"]
ToneSide = Literal["base", "source", "both", "none"]
Unit = Literal["mm", "cm", "m", "in"]


class TransferMethod(TypedDict, total=False):
    """Options of all transfers, of arrays, of files and onto avatars."""

    filter: Filter | None
    gutter: int
    prefer: Prefer
    blend: BlendMode | None
    tone: ToneSide | None
    match_skin: bool
    keep_all: bool

"""What can be said of an avatar, whatever its face is made of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Literal

from numpy.typing import ArrayLike

from uvgraft._types import Image, NormalY, Role, Size, StrPath, TransferMethod, Unit


class AvatarOptions(TransferMethod, total=False):
    """Options that `avatar` and `avatar_from_photos` share; `avatar` describes them."""

    motion: StrPath | Sequence[StrPath]
    fps: float | None
    ground: Literal["clip", "feet", "keep"] | None
    up: Literal["y", "z", "-y", "-z"] | None
    betas: ArrayLike | StrPath | None
    shape: Mapping[str, float] | None
    expressions: StrPath | None
    size: Size | None
    texture_layout: Literal["atlas", "head+body"]
    texture_format: Literal["png", "jpeg", "webp", "ktx2"] | None
    quality: int | None
    maps: Mapping[Role, Image] | None
    base_maps: Mapping[Role, Image] | None
    normal_y: NormalY
    look: Literal["pbr", "mtoon", "unlit"]
    mouth: Literal["fitted", "none"]
    eyes: Literal["keep", "clean"]
    region: str | Sequence[str]
    exclude: str | Sequence[str]
    grow: str | None
    unit: Unit | None
    source_mask: Image | None
    fill: Image | None
    preview: StrPath | None
    feather: str | None
    skin: Image | None
    labels: Image | None
    lods: int | None
    lods_as: Literal["files", "msft"] | None
    preset: Literal["quest", "pcvr", "web", "visionos"] | None
    triangles: int | None
    title: str | None
    author: str | Sequence[str]
    license: Literal["only-author", "non-commercial", "everyone"] | None
    license_url: str | None
    made_from: str | None
    format: Literal["glb", "vrm"]
    output: StrPath | None
    verbose: bool
    threads: int | None

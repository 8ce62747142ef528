"""The compiled part of uvgraft. Docstrings are those of the module: ``help(uvgraft.Graft)``."""

from collections.abc import Iterable, Sequence
from typing import Any, Literal, TypeAlias, final, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uvgraft._progress import GivenProgress
from uvgraft._region import Region
from uvgraft._results import Fit, Seams, Tone
from uvgraft._types import (
    BlendMode,
    Filter,
    Image,
    Images,
    MeshLike,
    NormalY,
    Overlap,
    Prefer,
    Side,
    Size,
    StrPath,
    ToneSide,
)

_ColorEncoding: TypeAlias = Literal["srgb", "linear"]
# Figures of a texture that was transferred, as `uvgraft.Transferred` names them.
_Figures: TypeAlias = tuple[float | None, int, int, int, list[str], list[str]]

__all__ = [
    "BodyModel",
    "Error",
    "Graft",
    "Mesh",
    "Operator",
    "Pair",
    "PreparedTransfer",
    "SamplingMap",
    "__version__",
    "choices",
    "compare",
    "flip",
    "get_threads",
    "is_pair_file",
    "l1",
    "load",
    "lpips",
    "make_avatar",
    "make_page",
    "make_picture",
    "make_selfie",
    "psnr",
    "read_image",
    "run_command",
    "seams",
    "set_threads",
    "ssim",
    "ssimulacra2",
    "write_image",
]
__version__: str

class Error(Exception): ...

@final
class Mesh:
    @overload
    def __new__(
        cls,
        positions: MeshLike,
        faces: None = None,
        uv: None = None,
        uv_faces: None = None,
        *,
        uv_origin: None = None,
        name: str | None = None,
    ) -> Mesh: ...
    @overload
    def __new__(
        cls,
        positions: ArrayLike,
        faces: ArrayLike,
        uv: ArrayLike,
        uv_faces: ArrayLike | None = None,
        *,
        uv_origin: Literal["bottom-left", "top-left"],
        name: str | None = None,
    ) -> Mesh: ...
    @staticmethod
    def load(path: StrPath) -> Mesh: ...
    @property
    def name(self) -> str: ...
    @property
    def positions(self) -> NDArray[np.float32]: ...
    @property
    def uv(self) -> NDArray[np.float32]: ...
    @property
    def faces(self) -> NDArray[np.uint32]: ...
    @property
    def uv_faces(self) -> NDArray[np.uint32]: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class Pair:
    def __new__(
        cls,
        source: MeshLike,
        target: MeshLike | None = None,
        *,
        vertex_map: ArrayLike | StrPath | None = None,
        table: StrPath | None = None,
        by: Literal["auto", "vertex-map", "table", "faces", "topology", "surface"] = "auto",
        align: Literal["similarity", "rigid", "none"] = "similarity",
        landmarks: ArrayLike | None = None,
        reach: float | None = None,
        visibility: float | None = None,
        outside: Literal["unlinked", "clamp", "repeat"] = "unlinked",
        flip_u: Side | Sequence[Side] | None = None,
        flip_v: Side | Sequence[Side] | None = None,
        note: str | None = None,
        threads: int | None = None,
    ) -> Pair: ...
    @staticmethod
    def load(path: StrPath) -> Pair: ...
    @staticmethod
    def from_bytes(data: bytes) -> Pair: ...
    def save(self, path: StrPath) -> None: ...
    def to_bytes(self) -> bytes: ...
    @property
    def source(self) -> Mesh: ...
    @property
    def target(self) -> Mesh: ...
    @property
    def note(self) -> str: ...
    @property
    def method(self) -> str | None: ...
    @property
    def piece_count(self) -> int: ...
    def __eq__(self, other: object, /) -> bool: ...
    def __ne__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

@final
class Graft:
    def __new__(
        cls,
        pair: Pair | StrPath,
        *,
        size: Size | None = None,
        reverse: bool = False,
        filter: Filter | None = None,
        gutter: int = 16,
        prefer: Prefer = "first",
        overlap: Overlap = "first",
        linear_light: bool = False,
        encoding: _ColorEncoding = "srgb",
        content: Literal["color", "data", "normals"] = "color",
        normal_y: NormalY = "opengl",
        normal_y_out: NormalY | None = None,
        region: Region | None = None,
        blend: BlendMode | None = None,
        feather: float | None = None,
        tone: ToneSide = "base",
        match_skin: bool = False,
        keep_all: bool = False,
        skin: Image | None = None,
        labels: Image | None = None,
        threads: int | None = None,
    ) -> Graft: ...
    @overload
    def apply(
        self,
        texture: list[Image] | tuple[Image, ...],
        base: Images | None = None,
        *,
        out: Any = None,
        threads: int | None = None,
    ) -> list[NDArray[Any]]: ...
    @overload
    def apply(
        self,
        texture: Image,
        base: Images | None = None,
        *,
        out: Any = None,
        threads: int | None = None,
    ) -> NDArray[Any]: ...
    @overload
    def __call__(
        self,
        texture: list[Image] | tuple[Image, ...],
        base: Images | None = None,
        *,
        out: Any = None,
        threads: int | None = None,
    ) -> list[NDArray[Any]]: ...
    @overload
    def __call__(
        self,
        texture: Image,
        base: Images | None = None,
        *,
        out: Any = None,
        threads: int | None = None,
    ) -> NDArray[Any]: ...
    def fit(
        self,
        texture: Image,
        base: Image | None = None,
        *,
        steps: int | None = None,
        min_gain: float | None = None,
        regularization: float | None = None,
        smoothness: float | None = None,
        progress: GivenProgress | None = None,
        out: NDArray[Any] | None = None,
        threads: int | None = None,
    ) -> Fit: ...
    def tone(
        self, texture: Image, base: Image | None = None, *, threads: int | None = None
    ) -> Tone | None: ...
    def mask(
        self, *, size: Size | None = None, source_size: Size | None = None
    ) -> NDArray[np.uint8]: ...
    def map(self, *, size: Size | None = None, source_size: Size | None = None) -> SamplingMap: ...
    def operator(self, *, size: Size | None = None, source_size: Size) -> Operator: ...
    def grid(self, size: Size | None = None, *, device: Any = None) -> Any: ...
    @property
    def pair(self) -> Pair: ...
    @property
    def reverse(self) -> bool: ...
    @property
    def region(self) -> Region | None: ...
    @property
    def filter(self) -> Filter: ...
    def __getnewargs_ex__(self) -> tuple[tuple[Pair], dict[str, Any]]: ...

@final
class SamplingMap:
    def __new__(
        cls,
        pair: Pair | StrPath,
        *,
        size: Size,
        reverse: bool = False,
        gutter: int = 16,
        prefer: Prefer = "first",
        threads: int | None = None,
    ) -> SamplingMap: ...
    @property
    def shape(self) -> tuple[int, int]: ...
    def uv(self, *, gutter: bool = True) -> NDArray[np.float32]: ...
    def _grid(self, *, gutter: bool = True) -> NDArray[np.float32]: ...
    def remap(
        self, source_size: Size, *, gutter: bool = True
    ) -> tuple[NDArray[np.float32], NDArray[np.float32]]: ...
    def faces(self, *, gutter: bool = False) -> NDArray[np.int32]: ...
    def mask(self) -> NDArray[np.uint8]: ...
    @property
    def stats(self) -> dict[str, int]: ...

@final
class Operator:
    @property
    def source_shape(self) -> tuple[int, int]: ...
    @property
    def target_shape(self) -> tuple[int, int]: ...
    def forward(self, texture: ArrayLike, *, threads: int | None = None) -> NDArray[np.float32]: ...
    def adjoint(self, texture: ArrayLike, *, threads: int | None = None) -> NDArray[np.float32]: ...
    def _forward_planes(
        self, planes: ArrayLike, *, threads: int | None = None
    ) -> NDArray[np.float32]: ...
    def _adjoint_planes(
        self, planes: ArrayLike, *, threads: int | None = None
    ) -> NDArray[np.float32]: ...
    def csr(
        self, *, threads: int | None = None
    ) -> tuple[
        tuple[NDArray[np.float32], NDArray[np.int32], NDArray[np.int64]], tuple[int, int]
    ]: ...

@final
class PreparedTransfer:
    def __new__(cls, arguments: dict[str, Any]) -> PreparedTransfer: ...
    def to_file(
        self, source: StrPath, output: StrPath, *, threads: int | None = None
    ) -> _Figures: ...
    def to_bytes(
        self,
        data: bytes,
        *,
        name: str = "texture",
        format: str = "png",
        threads: int | None = None,
    ) -> tuple[bytes, _Figures]: ...
    @property
    def fingerprint(self) -> str: ...
    @property
    def notes(self) -> list[str]: ...
    @property
    def shape(self) -> tuple[int, int]: ...
    def made_from_bytes(self, data: bytes) -> str: ...
    def made_from_file(self, source: StrPath) -> str: ...

def load(path: StrPath) -> Any: ...
def is_pair_file(path: StrPath) -> bool: ...
def read_image(path: StrPath) -> NDArray[Any]: ...
def write_image(
    path: StrPath,
    image: Image,
    *,
    encoding: Literal["srgb", "linear", "data"] = "srgb",
    compress: bool = False,
    quality: int | None = None,
) -> None: ...
def set_threads(threads: int) -> None: ...
def get_threads() -> int: ...
def make_avatar(
    file_name: StrPath, arguments: dict[str, Any]
) -> tuple[bytes, list[bytes], str, list[str]]: ...
def make_selfie(
    arguments: dict[str, Any],
) -> tuple[NDArray[np.uint8], NDArray[np.uint8], Mesh, str, str, NDArray[np.uint8] | None]: ...
def make_picture(arguments: dict[str, Any]) -> NDArray[np.uint8]: ...
def make_page(arguments: dict[str, Any]) -> bytes: ...
def run_command(arguments: Sequence[StrPath]) -> int: ...
def choices() -> dict[str, list[str]]: ...
def l1(
    reference: Image,
    test: Image,
    *,
    mask: Image | None = None,
    encoding: _ColorEncoding = "srgb",
    threads: int | None = None,
) -> float: ...
def psnr(
    reference: Image,
    test: Image,
    *,
    mask: Image | None = None,
    encoding: _ColorEncoding = "srgb",
    threads: int | None = None,
) -> float: ...
def ssim(
    reference: Image,
    test: Image,
    *,
    window: Literal["gaussian", "uniform"] = "gaussian",
    mask: Image | None = None,
    encoding: _ColorEncoding = "srgb",
    threads: int | None = None,
) -> float: ...
def ssimulacra2(
    reference: Image,
    test: Image,
    *,
    mask: Image | None = None,
    encoding: _ColorEncoding = "srgb",
    threads: int | None = None,
) -> float: ...
def flip(
    reference: Image,
    test: Image,
    *,
    mask: Image | None = None,
    encoding: _ColorEncoding = "srgb",
    threads: int | None = None,
) -> float: ...
def lpips(
    reference: Image,
    test: Image,
    *,
    network: Literal["alex", "vgg"] = "alex",
    weights: StrPath | None = None,
    mask: Image | None = None,
    encoding: _ColorEncoding = "srgb",
    threads: int | None = None,
) -> float: ...
def compare(
    reference: Image,
    test: Image,
    *,
    mask: Image | None = None,
    metrics: str | Iterable[str] | None = None,
    weights: StrPath | None = None,
    encoding: _ColorEncoding = "srgb",
    threads: int | None = None,
) -> dict[str, float]: ...
def seams(
    pair: Pair | StrPath | Graft,
    texture: Image,
    *,
    reverse: bool = False,
    region: Region | None = None,
    offset: float | None = None,
    distance: float | None = None,
    base: Image | None = None,
    face: Image | None = None,
    worst: int = 5,
    encoding: _ColorEncoding = "srgb",
    threads: int | None = None,
) -> Seams: ...

@final
class BodyModel:
    @staticmethod
    def load(
        path: StrPath, *, max_betas: int | None = None, correctives: bool = True
    ) -> BodyModel: ...
    @property
    def kind(self) -> Literal["SMPL", "SMPL-H", "SMPL-X", "FLAME"]: ...
    @property
    def gender(self) -> Literal["neutral", "male", "female"] | None: ...
    @property
    def license(self) -> str | None: ...
    @property
    def joint_names(self) -> list[str]: ...
    @property
    def parents(self) -> list[int]: ...
    @property
    def num_vertices(self) -> int: ...
    @property
    def num_joints(self) -> int: ...
    @property
    def num_betas(self) -> int: ...
    @property
    def num_expressions(self) -> int: ...
    @property
    def expression_names(self) -> list[str]: ...
    @property
    def shape_names(self) -> list[str]: ...
    @property
    def has_correctives(self) -> bool: ...
    @property
    def faces(self) -> NDArray[np.uint32]: ...
    def vertices(
        self,
        *,
        betas: ArrayLike | None = None,
        expression: ArrayLike | None = None,
        pose: ArrayLike | None = None,
        translation: ArrayLike | None = None,
        threads: int | None = None,
    ) -> NDArray[np.float32]: ...
    def joints(
        self,
        *,
        betas: ArrayLike | None = None,
        expression: ArrayLike | None = None,
        pose: ArrayLike | None = None,
        translation: ArrayLike | None = None,
        threads: int | None = None,
    ) -> NDArray[np.float32]: ...
    def mesh(
        self,
        layout: Mesh | None = None,
        *,
        betas: ArrayLike | None = None,
        expression: ArrayLike | None = None,
        pose: ArrayLike | None = None,
        translation: ArrayLike | None = None,
        threads: int | None = None,
    ) -> Mesh: ...
    def named_betas(self, **values: float) -> NDArray[np.float32]: ...
    def hand_pose(
        self, side: Literal["left", "right"], coefficients: ArrayLike
    ) -> NDArray[np.float32]: ...
    def hand_mean(self, side: Literal["left", "right"]) -> NDArray[np.float32] | None: ...

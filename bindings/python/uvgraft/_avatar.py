"""Animated avatars from textures of heads, and from photographs."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from uvgraft import _notebook
from uvgraft._avatar_options import AvatarOptions
from uvgraft._files import LocalFiles
from uvgraft._render import render
from uvgraft._types import Image, Relight, StrPath
from uvgraft._uvgraft import Error, Pair, make_avatar, make_page

if TYPE_CHECKING:
    from typing_extensions import Unpack

_GLB_MAGIC = b"glTF"


class Avatar:
    """An animated avatar: a GLB or VRM file in memory.

    Avatars are equal if their files are, and can be pickled. Notebooks show them in the viewer of
    ``uvgraft view``, in a frame without access to the notebook; or as a picture, if this build has
    no viewer or the cell would have more than 2.75 MB, which Jupyter does not pass on by default.
    Files of up to about 2.5 MB are below that: ``preset="web"``, or `size` 1024 and JPEG textures.

    Parameters
    ----------
    data : bytes
        A GLB or VRM file.
    name : str
        Its file name, which decides between ``.glb`` and ``.vrm``.
    report, notes
        See the properties.
    levels : sequence of bytes
        Files of coarser levels of detail.

    Raises
    ------
    uvgraft.Error
        If `data` is not a GLB or VRM file.
    """

    __slots__ = ("_data", "_levels", "_name", "_notes", "_picture", "_report")

    def __init__(
        self,
        data: bytes,
        *,
        name: str = "avatar.glb",
        report: str = "",
        notes: Sequence[str] = (),
        levels: Sequence[bytes] = (),
    ) -> None:
        if not data.startswith(_GLB_MAGIC):
            raise Error(f"{name}: must be a GLB or VRM file, starts with {data[:4]!r}")
        self._data = data
        self._name = name
        self._report = report
        self._notes = tuple(notes)
        self._levels = tuple(levels)
        self._picture: bytes | None = None

    @staticmethod
    def load(path: StrPath) -> Avatar:
        """Read a GLB or VRM file of any origin.

        Parameters
        ----------
        path : path
            The file.

        Raises
        ------
        uvgraft.Error
            For other files, such as glTF with its buffers beside it.
        OSError
            If it cannot be read.
        """
        return Avatar(Path(path).read_bytes(), name=Path(path).name)

    @property
    def data(self) -> bytes:
        """The bytes of the GLB or VRM file."""
        return self._data

    @property
    def name(self) -> str:
        """The file name."""
        return self._name

    @property
    def report(self) -> str:
        """Its figures, one a line, as ``uvgraft avatar`` prints them; empty for files."""
        return self._report

    @property
    def notes(self) -> tuple[str, ...]:
        """What was assumed, such as the unit of the mesh."""
        return self._notes

    @property
    def levels(self) -> tuple[bytes, ...]:
        """Files of coarser levels of detail."""
        return self._levels

    def save(self, path: StrPath) -> None:
        """Write the file, whole or not at all, and levels of detail beside it.

        Parameters
        ----------
        path : path
            The file. Levels are ``NAME.lod1.glb`` and so on.

        Raises
        ------
        ValueError
            If the extension is another than the avatar's: ``.glb`` or ``.vrm``.
        OSError
            If it cannot be written.
        """
        path = Path(path)
        extension = Path(self._name).suffix.lower()
        if path.suffix.lower() != extension:
            raise ValueError(f"{path}: extension must be {extension}")
        _check_folder(path)
        files = LocalFiles()
        for level, data in enumerate(self._levels, 1):
            files.write(os.fspath(path.with_name(f"{path.stem}.lod{level}{path.suffix}")), data)
        files.write(os.fspath(path), self._data)

    render = render

    def html(self, *, memory: int | str | None = None) -> str:
        """Return the page of ``uvgraft view``: the avatar and a viewer, which works offline.

        Parameters
        ----------
        memory : int or str, optional
            Bound on the memory of the process, in bytes or as in ``"500M"``: an avatar that could
            exceed it is refused. By default a gibibyte, and 200 times the size of the avatar.

        Returns
        -------
        str
            An HTML page.

        Raises
        ------
        uvgraft.Error
            If this build has no viewer, or the avatar could exceed the bound on memory.
        """
        return make_page({"avatar": self, "memory": memory}).decode()

    def _repr_html_(self) -> str:
        return _notebook.avatar_html(self)

    def _repr_png_(self) -> bytes:
        if self._picture is None:
            self._picture = _notebook.avatar_png(self)
        return self._picture

    def __repr__(self) -> str:
        """Show name and size."""
        return f"<uvgraft.Avatar {self._name!r}: {len(self._data) / 1e6:.1f} MB>"

    def __eq__(self, other: object) -> bool:
        """Compare the files."""
        if not isinstance(other, Avatar):
            return NotImplemented
        return (self._data, self._levels) == (other._data, other._levels)

    def __hash__(self) -> int:
        """Return the same for equal files."""
        return hash((self._data, self._levels))


def avatar(
    pair: Pair | StrPath,
    face: Image,
    *,
    onto: Image | str,
    body: StrPath | Literal["demo"],
    **options: Unpack[AvatarOptions],
) -> Avatar:
    """Build an animated avatar from the texture of a head, as ``uvgraft avatar`` does.

    The face is transferred onto the body's texture and blended; the body gets its skeleton,
    expressions, a mouth and animations.

    Parameters
    ----------
    pair : Pair or path
        Links the head to the body.
    face : image or path
        The face's texture in the head's layout, a texture dump of FATE (``.pth``), or the folder of
        a FATE workspace.
    onto : image, path or str
        The body's texture in its own layout, or a colour such as ``"#c08a70"``, with `size`.
    body : path or "demo"
        A model file of SMPL, SMPL-H, SMPL-X or FLAME (.npz, .pkl), or the built-in figure.
    **options
        See below.

    Other Parameters
    ----------------
    motion : path or sequence of paths
        AMASS recordings (.npz) to add as animations.
    fps : float, optional
        Frame rate of the animations, 0 for that of the recording. By default 30. Also the frame
        rate of recordings that state none.
    ground : {"clip", "feet", "keep"}, optional
        Where animations stand: on the recording's ground, on the avatar's own feet, or as recorded.
        By default clip.
    up : {"y", "z", "-y", "-z"}, optional
        Up axis of the recordings; ``"-y"`` is Y down, as in the axes of a camera. By default
        detected.
    betas : array_like of float, shape (n,), or path, optional
        Shape coefficients, or a file with an array ``betas``.
    shape : mapping of str to float, optional
        Shape by name, such as ``{"gender": 0.2, "height": 1.75}``, for the open body.
    expressions : path, optional
        Model file whose named expressions are carried to the body.
    size : int or (int, int), optional
        Size of the body's texture: a side in texels, or ``(height, width)``. By default the base's,
        within the preset.
    texture_layout : {"atlas", "head+body"}
        One texture in the body's layout, which is the default, or the head's beside it.
    texture_format : {"png", "jpeg", "webp", "ktx2"}, optional
        Format of embedded textures. By default the preset's, or png.
    quality : int, optional
        Quality of JPEG textures, 1 to 100. By default 92.
    filter : {"nearest", "bilinear", "catmull-rom", "lanczos3"}, optional
        Interpolation filter. By default lanczos3.
    gutter : int
        Width of the gutter around UV islands in texels, 0 to 256. By default 16.
    prefer : {"first", "left", "right"}
        UV island that owns texels that several cover. By default first.
    maps, base_maps : mapping of str to image or path, optional
        Further maps of the face and of the body by role: normal, roughness, metallic, occlusion,
        orm and emissive.
    normal_y : {"opengl", "directx"}
        Green channel convention of normal maps. By default opengl.
    look : {"pbr", "mtoon", "unlit"}
        Shading model. By default pbr.
    mouth : {"fitted", "none"}
        Interior of the mouth. By default fitted.
    eyes : {"keep", "clean"}
        Keep the eyes of the face's texture, which is the default, or redraw them in their colour.
    region, exclude : str or sequence of str
        Parts of the surface to use or leave out: ``"target:mask.png"``, ``"masks.pkl#face,neck"``.
    grow : str, optional
        Grow the region by a length, ``"5mm"``, or by ``"2rings"``; shrink it if negative. All but
        0 need a unit.
    unit : {"mm", "cm", "m", "in"}, optional
        Unit of the mesh coordinates. By default m.
    source_mask, fill : image or path, optional
        White where the face's texture can be trusted, and a mean texture for the rest.
    preview : path, optional
        Draw the transferred region and its weights on both layouts to this file.
    blend : {"none", "feather", "membrane"}, optional
        How to hide the boundary of the region. By default membrane.
    feather : str, optional
        Width of the feather, such as ``"10mm"``, the default. All but 0 need a unit.
    tone : {"base", "source", "both", "none"}, optional
        Side that sets the skin tone. By default source.
    skin : image or path, optional
        Skin mask of the base. By default detected.
    match_skin : bool
        Also match the colour statistics of skin.
    labels : image or path, optional
        Labels of the face's texture; detected ones are written to a path that does not exist.
    keep_all : bool
        Do not leave out cloth and background at the neck.
    lods : int, optional
        Number of coarser levels of detail, see `Avatar.levels`.
    lods_as : {"files", "msft"}, optional
        Files of their own, or one with MSFT_lod. By default files.
    preset : {"quest", "pcvr", "web", "visionos"}, optional
        Platform whose limits the avatar keeps.
    triangles : int, optional
        Maximum number of triangles. By default the preset's, or unlimited.
    title : str, optional
        Name of the avatar. By default that of the file.
    author : str or sequence of str
        Authors; required for VRM.
    license : {"only-author", "non-commercial", "everyone"}, optional
        What others may do with it; required for VRM, and for VRM only, as are `license_url` and
        `made_from`.
    license_url : str, optional
        URL of further terms.
    made_from : str, optional
        Third-party content and its licences.
    format : {"glb", "vrm"}
        What is built, unless `output` says so. By default glb.
    output : path, optional
        Also write the avatar to this file, which ends in ``.glb`` or ``.vrm``.
    verbose : bool
        List the unused arrays of the body model file in the report.
    threads : int, optional
        Number of threads, 0 for one per processor; see `set_threads`.

    Returns
    -------
    Avatar
        The avatar.

    Warns
    -----
    UserWarning
        For what may be implausible: expressions that the body cannot make, skin that is not found.

    Raises
    ------
    uvgraft.Error
        For files and options that cannot be used.
    TypeError, ValueError
        For arguments of another type or shape, and options that do not exist.
    OSError
        If a file does not exist, or cannot be read or written.
    """
    given = {"pair": pair, "face": face, "onto": onto, "body": body}
    return _build("avatar", given, options)


def avatar_from_photos(
    photos: Image | Sequence[Image],
    *,
    body: StrPath | Literal["demo"],
    pair: Pair | StrPath | None = None,
    onto: Image | str | None = None,
    likeness: float = 1.0,
    face_number: int | None = None,
    focal: float | str | None = None,
    head_texture: Image | None = None,
    relight: Relight = "soft",
    frames: int | None = None,
    **options: Unpack[AvatarOptions],
) -> Avatar:
    """Build an animated avatar from photographs, as ``uvgraft avatar --selfie`` does.

    The texture of the head is made as by `selfie`, and the body's head gets the shape of the face.

    Parameters
    ----------
    photos, face_number, focal, head_texture, relight, frames
        As for `selfie`.
    body : path or "demo"
        As for `avatar`, or the open body.
    pair : Pair or path, optional
        Links the head to the body; the built-in figure and the open body need none.
    onto : image, path or str, optional
        The body's texture; the built-in figure and the open body have their own.
    likeness : float
        How much of the face's shape the head gets, from 0 to 1.
    **options
        The other parameters of `avatar`: `motion`, `size`, `blend` and so on.

    Returns
    -------
    Avatar
        The avatar.

    Warns
    -----
    UserWarning
        As `selfie` and `avatar` do.

    Raises
    ------
    uvgraft.Error
        For photographs without a usable face, if the networks that find faces were not imported,
        and for files and options that cannot be used.
    TypeError, ValueError
        For arguments of another type or shape, and options that do not exist.
    OSError
        If a file does not exist, or cannot be read or written.
    """
    of_photos = {
        "photos": photos,
        "body": body,
        "pair": pair,
        "onto": onto,
        "likeness": likeness,
        "face_number": face_number,
        "focal": focal,
        "head_texture": head_texture,
        "relight": relight,
        "frames": frames,
    }
    return _build("avatar_from_photos", of_photos, options)


def _build(call: str, given: dict[str, Any], options: AvatarOptions) -> Avatar:
    """Build an avatar from the arguments of a function above."""
    for name in options:
        if name not in AvatarOptions.__annotations__:
            raise TypeError(f"{call}() got an unexpected keyword argument {name!r}")
    given = {**given, **options}
    kind, output = given.pop("format", None) or "glb", given.get("output")
    if not isinstance(kind, str):
        raise TypeError(f"format must be a str, got {type(kind).__name__}")
    if output is None:
        name = f"avatar.{kind}"
    else:
        name = Path(output).name
        _check_folder(Path(output))
    file, levels, report, notes = make_avatar(name, given)
    built = Avatar(file, name=name, report=report, notes=notes, levels=levels)
    if output is not None:
        built.save(output)
    return built


def _check_folder(path: Path) -> None:
    """Check that a file's folder exists, which would be created otherwise."""
    if not path.parent.is_dir():
        raise FileNotFoundError(f"{path}: folder {path.parent} does not exist")

"""Transfers of encoded images, prepared once."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from typing import Any, Literal, NamedTuple

from uvgraft._uvgraft import PreparedTransfer

StrPath = str | os.PathLike[str]


class Transferred(NamedTuple):
    """What became of a texture.

    Attributes
    ----------
    boundary_delta_e : float or None
        How much texture and base still differ along the boundary once their skin matches, ΔE 2000;
        None without a blend that matches tones, and where no skin meets skin.
    bytes : int
        Length of the encoded result.
    height, width : int
        Size of the result in texels.
    warnings, notes : list of str
        Each names the texture.
    """

    boundary_delta_e: float | None
    bytes: int
    height: int
    width: int
    warnings: list[str]
    notes: list[str]


class FileTransfer:
    """A transfer of encoded images, byte for byte as ``uvgraft transfer`` writes them.

    The pair is read, the base decoded and the blend prepared when the object is made; each texture
    then costs its own decoding, sampling and encoding. Any number of threads may use an object at
    once. Its pickle holds the arguments alone: it is prepared again where it is loaded.

    Parameters
    ----------
    pair : path
        A pair file.
    onto : path or str, optional
        The base: an image, or a colour such as ``"#808080"``. By default transparent.
    size : int or (int, int), optional
        Size of the result: a side in texels, or ``(height, width)``. By default the base's.
    reverse : bool
        Transfer from the pair's target to its source.
    filter : {"nearest", "bilinear", "catmull-rom", "lanczos3"}, optional
        By default lanczos3, and bilinear for data.
    gutter : int
        Width of the gutter around UV islands in texels, 0 to 256.
    prefer : {"first", "left", "right"}
        UV island that owns texels that several cover.
    overlap : {"first", "average"}
        How overlapping UV islands are combined.
    linear_light : bool
        Average colours in linear light instead of as encoded.
    data : bool
        Treat textures as data, and never convert their values.
    fit : bool
        Solve for the texture that best reproduces the source.
    fit_steps : int, optional
        Maximum number of steps of a fit.
    region, exclude : sequence of str
        Parts of the surface, as ``uvgraft transfer --region`` takes them: ``"target:mask.png"``,
        ``"masks.pkl#face,neck"``.
    grow : str, optional
        Grow the region by a length or by rings: ``"-5mm"``, ``"2rings"``.
    unit : {"mm", "cm", "m", "in"}, optional
        Unit of the mesh coordinates.
    blend : {"none", "feather", "membrane"}, optional
        How to hide the boundary of the region.
    feather : str, optional
        Width of the feather, such as ``"10mm"``.
    tone : {"base", "source", "both", "none"}, optional
        Side that sets the skin tone.
    match_skin : bool
        Also match the colour statistics of skin.
    keep_all : bool
        Do not leave out cloth and background at the neck.
    skin, labels, source_mask, fill : path, optional
        Images: the base's skin, the texture's labels, its trusted texels, and a mean texture.
    compress : bool
        Write smaller files, more slowly.
    quality : int
        JPEG quality, 1 to 100.
    threads : int, optional
        Threads of a call, 0 for one per processor; see `set_threads`.

    Raises
    ------
    uvgraft.Error
        For files and options that cannot be used.
    FileNotFoundError
        If the pair does not exist.
    """

    def __init__(
        self,
        pair: StrPath,
        *,
        onto: StrPath | None = None,
        size: int | tuple[int, int] | None = None,
        reverse: bool = False,
        filter: str | None = None,
        gutter: int = 16,
        prefer: str = "first",
        overlap: str = "first",
        linear_light: bool = False,
        data: bool = False,
        fit: bool = False,
        fit_steps: int | None = None,
        region: Iterable[str] = (),
        exclude: Iterable[str] = (),
        grow: str | None = None,
        unit: str | None = None,
        blend: str | None = None,
        feather: str | None = None,
        tone: str | None = None,
        match_skin: bool = False,
        keep_all: bool = False,
        skin: StrPath | None = None,
        labels: StrPath | None = None,
        source_mask: StrPath | None = None,
        fill: StrPath | None = None,
        compress: bool = False,
        quality: int = 95,
        threads: int | None = None,
    ) -> None:
        values: dict[str, Any] = {
            "onto": onto,
            "size": _spelled_size(size),
            "reverse": reverse,
            "filter": filter,
            "gutter": gutter,
            "prefer": prefer,
            "overlap": overlap,
            "linear_light": linear_light,
            "data": data,
            "fit": fit,
            "fit_steps": fit_steps,
            "grow": grow,
            "unit": unit,
            "blend": blend,
            "feather": feather,
            "tone": tone,
            "match": "skin" if match_skin else None,
            "keep_all": keep_all,
            "skin": skin,
            "labels": labels,
            "source_mask": source_mask,
            "fill": fill,
            "compress": compress,
            "quality": quality,
        }
        parts = {"region": _listed(region), "exclude": _listed(exclude)}
        # The parser wants a texture and an output, which come with each call.
        arguments = [*_spelled(values), *_repeated(parts), "--output=texture.png", "--"]
        self._arguments = [*arguments, os.fspath(pair), "texture.png"]
        self._threads = threads
        self._prepared = PreparedTransfer(self._arguments, threads=threads)

    @property
    def fingerprint(self) -> str:
        """Of all options and all files that textures share: 64 hexadecimal digits."""
        return self._prepared.fingerprint

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width of results in texels."""
        return self._prepared.shape

    def to_file(
        self, source: StrPath, output: StrPath, *, threads: int | None = None
    ) -> Transferred:
        """Transfer an image file to a file, which appears when it is whole.

        Parameters
        ----------
        source : path
            An image in the source layout.
        output : path
            Its extension says the format; its folder must exist.
        threads : int, optional
            In place of the object's own.

        Raises
        ------
        uvgraft.Error
            For a source that is not an image or does not suit the options, and for an output that
            cannot be written, which is then unchanged.
        FileNotFoundError
            If the source does not exist.
        """
        return Transferred(*self._prepared.to_file(source, output, threads=threads))

    def to_bytes(
        self,
        data: bytes,
        *,
        name: str = "texture",
        format: Literal["png", "jpg", "jpeg", "webp", "tif", "tiff", "exr"] | str = "png",
        threads: int | None = None,
    ) -> tuple[bytes, Transferred]:
        """Transfer an encoded image.

        Parameters
        ----------
        data : bytes
            An image in any format.
        name : str
            What messages call it.
        format : str
            The format of the result, by its extension.
        threads : int, optional
            In place of the object's own.

        Returns
        -------
        bytes
            What `to_file` would write.
        Transferred
            Figures.

        Raises
        ------
        uvgraft.Error
            For bytes that are not an image, and an image that does not suit the options.
        """
        encoded, figures = self._prepared.to_bytes(data, name=name, format=format, threads=threads)
        return encoded, Transferred(*figures)

    def made_from(self, source: bytes | StrPath) -> str:
        """Return the fingerprint of everything that a result is made from, its source included.

        Parameters
        ----------
        source : bytes or path
            An encoded image. The fingerprint is that of its content.

        Returns
        -------
        str
            64 hexadecimal digits, as recorded by ``uvgraft transfer --skip-existing``.
        """
        if isinstance(source, bytes):
            return self._prepared.made_from_bytes(source)
        return self._prepared.made_from_file(source)

    def __repr__(self) -> str:
        """Show the arguments."""
        return f"<uvgraft.FileTransfer: {' '.join(self._arguments)}>"

    def __getstate__(self) -> dict[str, Any]:
        """Leave out what can be prepared again."""
        return {"arguments": self._arguments, "threads": self._threads}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Prepare the transfer again."""
        self._arguments = state["arguments"]
        self._threads = state["threads"]
        self._prepared = PreparedTransfer(self._arguments, threads=self._threads)


def _spelled_size(size: int | tuple[int, int] | None) -> str | None:
    """Spell a size as the command line does: width first."""
    if size is None:
        return None
    if isinstance(size, tuple):
        return "x".join(str(int(side)) for side in reversed(size))
    return str(int(size))


def _listed(parts: Iterable[str]) -> list[str]:
    return [parts] if isinstance(parts, str) else [os.fspath(part) for part in parts]


def _spelled(values: dict[str, Any]) -> Iterator[str]:
    """Spell options as the command line does."""
    for name, value in values.items():
        option = "--" + name.replace("_", "-")
        if value is True:
            yield option
        elif value is not None and value is not False:
            # One argument, so that no value can pass for an option.
            yield f"{option}={os.fspath(value) if isinstance(value, os.PathLike) else value}"


def _repeated(values: dict[str, list[str]]) -> Iterator[str]:
    for name, parts in values.items():
        for part in parts:
            yield f"--{name}={part}"

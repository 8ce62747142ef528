"""Transfers of encoded images, prepared once."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from uvgraft._types import Overlap, Size, StrPath, TransferMethod, Unit
from uvgraft._uvgraft import PreparedTransfer

if TYPE_CHECKING:
    from typing_extensions import Unpack


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


class TransferOptions(TransferMethod, total=False):
    """Options that `FileTransfer` and `uvgraft.batch.BatchTransfer` share; the former has them."""

    onto: StrPath | None
    size: Size | None
    reverse: bool
    overlap: Overlap
    linear_light: bool
    data: bool
    fit: bool
    fit_steps: int | None
    region: str | Sequence[str]
    exclude: str | Sequence[str]
    grow: str | None
    unit: Unit | None
    feather: str | None
    skin: StrPath | None
    labels: StrPath | None
    source_mask: StrPath | None
    fill: StrPath | None
    compress: bool
    quality: int


class FileTransfer:
    """A transfer of encoded images, byte for byte as ``uvgraft transfer`` writes them.

    The pair is read, the base decoded and the blend prepared when the object is made; each texture
    then costs its own decoding, sampling and encoding. Any number of threads may use an object at
    once. Its pickle holds the arguments alone: it is prepared again where it is loaded.

    Parameters
    ----------
    pair : path
        A pair file.
    threads : int, optional
        Threads of a call, 0 for one per processor; see `set_threads`.
    **options
        See below.

    Other Parameters
    ----------------
    onto : path or str, optional
        The base: an image, or a colour such as ``"#808080"``. By default transparent.
    size : int or (int, int), optional
        Size of the result: a side in texels, or ``(height, width)``. By default the base's.
    reverse : bool
        Transfer from the pair's target to its source.
    filter : {"nearest", "bilinear", "catmull-rom", "lanczos3"}, optional
        By default lanczos3, and bilinear for data.
    gutter : int
        Width of the gutter around UV islands in texels, 0 to 256. By default 16.
    prefer : {"first", "left", "right"}
        UV island that owns texels that several cover. By default first.
    overlap : {"first", "average"}
        How overlapping UV islands are combined. By default first.
    linear_light : bool
        Average colours in linear light instead of as encoded.
    data : bool
        Treat textures as data, and never convert their values.
    fit : bool
        Solve for the texture that best reproduces the source.
    fit_steps : int, optional
        Maximum number of steps of a fit.
    region, exclude : str or sequence of str
        Parts of the surface, as ``uvgraft transfer --region`` takes them: ``"target:mask.png"``,
        ``"masks.pkl#face,neck"``.
    grow : str, optional
        Grow the region by a length, ``"5mm"``, or by ``"2rings"``; shrink it if negative. All but
        0 need a unit.
    unit : {"mm", "cm", "m", "in"}, optional
        Unit of the mesh coordinates. By default m.
    blend : {"none", "feather", "membrane"}, optional
        How to hide the boundary of the region. By default none, or feather with one.
    feather : str, optional
        Width of the feather, such as ``"10mm"``, the default. All but 0 need a unit.
    tone : {"base", "source", "both", "none"}, optional
        Side that sets the skin tone. By default base.
    match_skin : bool
        Also match the colour statistics of skin.
    keep_all : bool
        Do not leave out cloth and background at the neck.
    skin, labels, source_mask, fill : path, optional
        Images: the base's skin, the texture's labels, its trusted texels, and a mean texture.
    compress : bool
        Write smaller files, more slowly.
    quality : int
        JPEG quality, 1 to 100. By default 95.

    Warns
    -----
    UserWarning
        For what is implausible about the region and the base. `Transferred` has the warnings of
        each texture.

    Raises
    ------
    uvgraft.Error
        For files and options that cannot be used.
    TypeError, ValueError
        For arguments of another type, and options that do not exist.
    OSError
        If a file does not exist or cannot be read.
    """

    def __init__(
        self, pair: StrPath, *, threads: int | None = None, **options: Unpack[TransferOptions]
    ) -> None:
        for name in options:
            if name not in TransferOptions.__annotations__:
                raise TypeError(f"FileTransfer() got an unexpected keyword argument {name!r}")
        self._arguments = {"pair": pair, **options, "threads": threads}
        self._prepared = PreparedTransfer(self._arguments)

    @property
    def fingerprint(self) -> str:
        """Of all options and all files that textures share: 64 hexadecimal digits."""
        return self._prepared.fingerprint

    @property
    def notes(self) -> list[str]:
        """What preparing assumed, such as the unit of the mesh."""
        return self._prepared.notes

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
        pair, *others = self._arguments.items()
        shown = [f"{name}={value!r}" for name, value in others if value is not None]
        return f"<uvgraft.FileTransfer: {', '.join([repr(pair[1]), *shown])}>"

    def __getstate__(self) -> dict[str, Any]:
        """Leave out what can be prepared again."""
        return self._arguments

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Prepare the transfer again."""
        self._arguments = state
        self._prepared = PreparedTransfer(state)

"""How results look in notebooks."""

from __future__ import annotations

import base64
import gzip
import html
import os
import struct
import zlib
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from uvgraft._types import Image
from uvgraft._uvgraft import Error, Mesh, Pair, SamplingMap, read_image

if TYPE_CHECKING:
    from uvgraft._avatar import Avatar

# Jupyter's server passes on 3 MB of results within 3 seconds unless it is told otherwise
# (`iopub_data_rate_limit`), and drops what is beyond; the picture beside the page needs some.
MAX_PAGE_BYTES = 2_750_000
VIEWER_HEIGHT = 560
AVATAR_SIZE = (768, 576)

MAX_SIDE = 1024
_CHECK = 8
_CHECKS = np.array([[102, 153], [153, 102]], np.float32)
_NOT_FINITE = np.array([255, 0, 255], np.float32)

PANEL = 512
_MARGIN = 12
_BACKGROUND = (24, 26, 30)
_OUTSIDE = (12, 13, 15)
_UNLINKED = (74, 78, 86)
_BORDER = (236, 238, 242)
# The colours of `uvgraft pair --preview`: top left, top right, bottom left, bottom right.
_CORNERS = np.array(
    [[[240, 110, 90], [245, 200, 80]], [[90, 120, 230], [70, 200, 160]]], np.float32
)
_CHECKS_A_SIDE = 16


def png(picture: NDArray[np.uint8]) -> bytes:
    """Encode a picture.

    Parameters
    ----------
    picture : ndarray of uint8, shape (height, width, 3)
        A picture in sRGB.
    """
    height, width, _ = picture.shape
    # Each row starts with its filter, 0 for none.
    rows = np.zeros((height, 1 + 3 * width), np.uint8)
    rows[:, 1:] = picture.reshape(height, -1)
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    parts = [(b"IHDR", header), (b"IDAT", zlib.compress(rows.tobytes(), 6)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
        for name, data in parts
    )


def image_html(data: bytes, alternative: str) -> str:
    """Return an element that shows a PNG."""
    source = base64.b64encode(data).decode()
    return f'<img src="data:image/png;base64,{source}" alt="{html.escape(alternative)}">'


class TextureView:
    """A texture as notebooks show it: at most 1024 pixels a side, over checks where it is clear.

    Made by `show`.
    """

    __slots__ = ("_picture", "_what")

    def __init__(self, texture: NDArray[Any]) -> None:
        self._picture = picture_of(texture)
        self._what = f"{texture.dtype} {tuple(texture.shape)}"

    @property
    def picture(self) -> NDArray[np.uint8]:
        """The picture, of shape ``(height, width, 3)``."""
        return self._picture

    def _repr_png_(self) -> bytes:
        return png(self._picture)

    def __repr__(self) -> str:
        """Describe the texture."""
        return f"<uvgraft.TextureView: {self._what}>"


def show(texture: Image) -> TextureView:
    """Show a texture in a notebook's cell.

    Large textures are reduced to at most 1024 pixels a side; whatever is transparent has checks
    beneath it, and NaN and infinite values are magenta.

    Parameters
    ----------
    texture : ndarray, PIL image or path
        Of shape ``(height, width)`` or ``(height, width, channels)`` with 1 to 4 channels; dtype
        bool, uint8, uint16, or float where 1.0 is white.

    Returns
    -------
    TextureView
        What notebooks draw.

    Raises
    ------
    TypeError
        For other dtypes.
    ValueError
        For other shapes, and for textures without texels.
    """
    is_path = isinstance(texture, str | os.PathLike)
    return TextureView(read_image(texture) if is_path else np.asarray(texture))


def texture_png(texture: NDArray[Any]) -> bytes:
    """Encode a picture of a texture."""
    return png(picture_of(texture))


def picture_of(texture: NDArray[Any]) -> NDArray[np.uint8]:
    """Draw a texture as `show` describes.

    Returns
    -------
    ndarray of uint8, shape (height, width, 3)
        At most `MAX_SIDE` pixels a side.
    """
    color, alpha = _color_and_alpha(texture)
    factor = -(-max(texture.shape[:2]) // MAX_SIDE)
    # Averaged with alpha, so that the colours of clear texels do not show.
    color, alpha = _reduced(color * alpha, factor), _reduced(alpha, factor)
    rows, columns = np.indices(alpha.shape[:2]) // _CHECK % 2
    drawn = color + (1 - alpha) * _CHECKS[rows, columns][..., None]
    picture: NDArray[np.uint8] = np.rint(drawn).clip(0, 255).astype(np.uint8)
    return picture


def _color_and_alpha(texture: NDArray[Any]) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return RGB from 0 to 255, and alpha from 0 to 1."""
    texels = texture[..., None] if texture.ndim == 2 else texture
    if texels.ndim != 3 or not 1 <= texels.shape[2] <= 4 or texels.size == 0:
        raise ValueError(
            "texture must have shape (height, width) or (height, width, channels) with 1 to 4 "
            f"channels, got {texture.shape}"
        )
    whites = {"b": 1.0, "f": 1.0}
    if texels.dtype in (np.uint8, np.uint16):
        whites["u"] = float(np.iinfo(texels.dtype).max)
    white = whites.get(texels.dtype.kind)
    if white is None:
        raise TypeError(
            f"texture must have dtype bool, uint8, uint16 or float, got {texture.dtype}"
        )
    values = texels.astype(np.float32) / np.float32(white)
    known = np.isfinite(values).all(axis=2)
    values = np.nan_to_num(values, nan=0.0, posinf=0.0, neginf=0.0).clip(0, 1)
    has_alpha = values.shape[2] in (2, 4)
    alpha = values[..., -1:] if has_alpha else np.ones_like(values[..., :1])
    color = values[..., :-1] if has_alpha else values
    color = np.broadcast_to(color, (*color.shape[:2], 3)) * np.float32(255)
    color[~known] = _NOT_FINITE
    return color, np.where(known[..., None], alpha, np.float32(1))


def _reduced(values: NDArray[np.float32], factor: int) -> NDArray[np.float32]:
    """Average squares of texels; those at the end repeat the last ones."""
    if factor == 1:
        return values
    height, width, channels = values.shape
    padding = [(0, -height % factor), (0, -width % factor), (0, 0)]
    values = np.pad(values, padding, mode="edge")
    rows, columns = values.shape[0] // factor, values.shape[1] // factor
    squares = values.reshape(rows, factor, columns, factor, channels)
    means: NDArray[np.float32] = squares.mean(axis=(1, 3))
    return means


def pair_png(pair: Pair) -> bytes:
    """Draw both layouts of a pair, the source on the left.

    Linked texels have the same colours on both sides, by their position in the source; the rest of
    the layouts is grey.
    """
    return png(pair_picture(pair))


def pair_picture(pair: Pair) -> NDArray[np.uint8]:
    """Draw both layouts of a pair.

    Returns
    -------
    ndarray of uint8, shape (536, 1060, 3)
        The picture.
    """
    forward = SamplingMap(pair, size=PANEL, gutter=0).uv()
    backward = SamplingMap(pair, size=PANEL, reverse=True, gutter=0).mask() > 0
    centers = (np.arange(PANEL, dtype=np.float32) + 0.5) / PANEL
    own = np.stack(np.meshgrid(centers, centers), axis=2).astype(np.float32)
    own[~backward] = np.nan
    picture = np.full((PANEL + 2 * _MARGIN, 2 * PANEL + 3 * _MARGIN, 3), _BACKGROUND, np.uint8)
    panels = [_panel(pair.source, own), _panel(pair.target, forward)]
    for index, panel in enumerate(panels):
        left = _MARGIN + index * (PANEL + _MARGIN)
        picture[_MARGIN:-_MARGIN, left : left + PANEL] = panel
    return picture


def _panel(mesh: Mesh, source_uv: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Draw a layout; linked texels have positions in the source, the others NaN."""
    panel = np.full((PANEL, PANEL, 3), _OUTSIDE, np.uint8)
    islands = _covered(mesh)
    panel[islands] = _UNLINKED
    linked = ~np.isnan(source_uv[..., 0])
    panel[linked] = _place_colors(source_uv[linked])
    panel[islands & ~_eroded(islands)] = _BORDER
    return panel


def _covered(mesh: Mesh) -> NDArray[np.bool_]:
    """Find the texels that a layout covers."""
    same = Pair(mesh, mesh, vertex_map=np.arange(len(mesh.positions)))
    return SamplingMap(same, size=PANEL, gutter=0).mask() > 0


def _eroded(mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
    padded = np.pad(mask, 1)
    return (
        mask & padded[2:, 1:-1] & padded[:-2, 1:-1] & padded[1:-1, 2:] & padded[1:-1, :-2]
    )  # fmt: skip


def _place_colors(uv: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return a colour for each position in the unit square: corner colours blended, with checks."""
    s, t = uv[:, :1].clip(0, 1), uv[:, 1:].clip(0, 1)
    top = _CORNERS[0, 0] * (1 - s) + _CORNERS[0, 1] * s
    bottom = _CORNERS[1, 0] * (1 - s) + _CORNERS[1, 1] * s
    is_dark = np.floor(uv * _CHECKS_A_SIDE).sum(axis=1) % 2 == 1
    color = (top * (1 - t) + bottom * t) * np.where(is_dark, 0.82, 1.0)[:, None]
    rounded: NDArray[np.uint8] = color.astype(np.uint8)
    return rounded


def pair_html(pair: Pair) -> str:
    """Describe a pair, with the picture of its layouts."""
    picture = image_html(pair_png(pair), "both layouts, linked texels in colour")
    names = " → ".join(html.escape(mesh.name) for mesh in (pair.source, pair.target))
    method = "" if pair.method is None else f", linked by {html.escape(pair.method)}"
    return (
        f"<figure><figcaption><b>{names}</b>: {pair.piece_count:,} pieces{method}</figcaption>"
        f"{picture}</figure>"
    )


def avatar_png(avatar: Avatar) -> bytes:
    """Draw an avatar."""
    return png(avatar.render(size=AVATAR_SIZE))


def avatar_html(avatar: Avatar) -> str:
    """Return the viewer with an avatar in it, or its picture.

    It is the picture if this build has no viewer, and if the cell's content would be longer than
    `MAX_PAGE_BYTES`.
    """
    try:
        shown = viewer_html(avatar.html())
    except Error as reason:
        return _pictured(avatar, str(reason))
    if len(shown) <= MAX_PAGE_BYTES:
        return shown
    return _pictured(
        avatar,
        f"The viewer with this avatar has {len(shown) / 1e6:.1f} MB, too much for a notebook; "
        "write avatar.html() to a file and open it in a browser.",
    )


def _pictured(avatar: Avatar, caption: str) -> str:
    picture = image_html(avatar._repr_png_(), "the avatar")
    return (
        f"<figure>{picture}<figcaption><small>{html.escape(caption)}</small></figcaption></figure>"
    )


_UNPACKER = """<!DOCTYPE html><meta charset="utf-8"><script>
(async () => {
  const packed = Uint8Array.from(atob("%s"), (character) => character.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const page = await new Response(stream).text();
  document.open();
  document.write(page);
  document.close();
})();
</script>"""


def viewer_html(page: str) -> str:
    """Put a page into a frame without access to the notebook; the page is compressed.

    Parameters
    ----------
    page : str
        A whole HTML page.
    """
    # Without a time, the same avatar always gives the same cell.
    packed = base64.b64encode(gzip.compress(page.encode(), mtime=0)).decode()
    document = html.escape(_UNPACKER % packed)
    return (
        f'<iframe srcdoc="{document}" sandbox="allow-scripts allow-downloads" title="avatar" '
        f'style="width: 100%; height: {VIEWER_HEIGHT}px; border: 0"></iframe>'
    )


def seams_html(seams: Any) -> str:
    """Return tables of a named tuple of figures, which may hold others.

    Fields that are named tuples of one type are the rows of one table, a list of named tuples is a
    table, and everything else goes into a table of names and values.

    Parameters
    ----------
    seams : NamedTuple
        The figures.
    """
    fields = seams._asdict()
    groups: dict[type, dict[str, Any]] = {}
    for name, value in fields.items():
        if _is_record(value):
            groups.setdefault(type(value), {})[name] = value
    tables = [_table(rows) for rows in groups.values()]
    plain: dict[str, Any] = {}
    for name, value in fields.items():
        if isinstance(value, list) and value and all(map(_is_record, value)):
            numbered = {str(number): row for number, row in enumerate(value, 1)}
            tables.append(_table(numbered, caption=name))
        elif isinstance(value, Mapping):
            plain |= {f"{name}: {key}": inner for key, inner in value.items()}
        elif not _is_record(value):
            plain[name] = value
    if plain:
        tables.append(_rows_html((name, _text(value)) for name, value in plain.items()))
    return "".join(tables)


def _is_record(value: object) -> bool:
    return isinstance(value, tuple) and hasattr(value, "_asdict")


def _is_nested(value: object) -> bool:
    """Whether it is positions rather than a figure."""
    return isinstance(value, tuple) and any(isinstance(part, tuple) for part in value)


def _flat(record: Any) -> dict[str, str]:
    """Return the figures of a record by their names, with those of records in it.

    Positions are left out: they would fill the table.
    """
    flat: dict[str, str] = {}
    for name, value in record._asdict().items():
        if _is_record(value):
            flat |= {f"{name} {inner}": text for inner, text in _flat(value).items()}
        elif not _is_nested(value):
            flat[name] = _text(value)
    return flat


def _table(records: Mapping[str, Any], caption: str = "") -> str:
    """Return a table with a row for each record."""
    rows = {name: _flat(record) for name, record in records.items()}
    columns = list(dict.fromkeys(column for row in rows.values() for column in row))
    # A record that is missing has one column of its own name, which others have several of.
    columns = [name for name in columns if not any(it.startswith(f"{name} ") for it in columns)]
    heads = [caption, *columns]
    body = ([name, *(row.get(column, "–") for column in columns)] for name, row in rows.items())
    return _rows_html(body, heads)


def _rows_html(rows: Iterable[Iterable[str]], heads: Iterable[str] = ()) -> str:
    def cells(kind: str, texts: Iterable[str]) -> str:
        return "".join(f"<{kind}>{html.escape(_title(text))}</{kind}>" for text in texts)

    head = cells("th", heads)
    body = "".join(f"<tr>{cells('td', row)}</tr>" for row in rows)
    return (
        f"<table>{f'<thead><tr>{head}</tr></thead>' if head else ''}<tbody>{body}</tbody></table>"
    )


def _title(name: str) -> str:
    return name.replace("_", " ").replace("delta e", "ΔE")


def _text(value: object) -> str:
    """Spell a figure in three digits."""
    if value is None:
        return "–"
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, int | np.integer):
        return f"{value:,}"
    if isinstance(value, float | np.floating):
        return f"{value:.3g}"
    if isinstance(value, tuple | list):
        return f"({', '.join(map(_text, value))})"
    return str(value)

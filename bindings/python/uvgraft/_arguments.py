"""Arguments of the command from Python values.

What the command reads from files is written to a temporary folder first, without loss.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from uvgraft._file_transfer import _spelled, _spelled_size
from uvgraft._uvgraft import Mesh, Pair, write_image

StrPath: TypeAlias = str | os.PathLike[str]
# An array, a PIL image, anything else with `__array__`, or the path of an image file.
Image: TypeAlias = Any
Size: TypeAlias = int | tuple[int, int]


def is_path(given: object) -> bool:
    """Whether an argument is a path rather than a value."""
    return isinstance(given, str | os.PathLike)


class Arguments:
    """Arguments of a subcommand, and the folder of the files that they name.

    Parameters
    ----------
    command : str
        The subcommand.
    folder : path
        An empty folder.
    """

    def __init__(self, command: str, folder: StrPath) -> None:
        self.words: list[str] = [command]
        self._folder = Path(folder)

    def options(self, **values: Any) -> None:
        """Add options by their names with underscores; None and False add nothing."""
        plain = {k: bool(v) if isinstance(v, np.bool_) else v for k, v in values.items()}
        self.words += _spelled(plain)

    def repeated(self, name: str, values: str | os.PathLike[str] | Iterable[StrPath]) -> None:
        """Add an option for each value, or for the only one."""
        for value in [values] if isinstance(values, str | os.PathLike) else values:
            self.words.append(f"--{name}={os.fspath(value)}")

    def positional(self, *paths: StrPath) -> None:
        """End the arguments with paths, none of which can pass for an option."""
        self.words += ["--", *(os.fspath(path) for path in paths)]

    def size(self, size: Size | None) -> None:
        """Add a size given as ``(height, width)`` or a side."""
        if isinstance(size, Sequence) and not isinstance(size, tuple):
            size = tuple(size)
        self.options(size=_spelled_size(size))

    def images(self, **images: Image | None) -> None:
        """Add options that name images."""
        for name, image in images.items():
            if image is not None:
                self.options(**{name: self.image(name, image)})

    def maps(self, option: str, maps: Mapping[str, Image]) -> None:
        """Add images by role; data keeps its values."""
        for role, given in maps.items():
            is_data = role.lower() != "emissive"
            path = self.image(f"{option}_{role}", given, is_data=is_data)
            self.words.append(f"--{option}={role}={path}")

    def image(self, name: str, given: Image, *, is_data: bool = False) -> str:
        """Return the path of an image, which is written if it is not one already."""
        if is_path(given):
            return os.fspath(given)
        # The only format that keeps 32-bit floats and straight alpha.
        extension = "tif" if np.asarray(given).dtype.kind == "f" else "png"
        path = self._folder / f"{name}.{extension}"
        try:
            write_image(path, given, encoding="data" if is_data else "srgb")
        except (TypeError, ValueError) as error:
            raise type(error)(str(error).replace("image", name, 1)) from None
        return os.fspath(path)

    def photographs(self, given: Image | Sequence[Image]) -> list[str]:
        """Return the paths of one photograph or several."""
        is_one = is_path(given) or hasattr(given, "getbands") or getattr(given, "ndim", 4) < 4
        photos = [given] if is_one else list(given)
        if not photos:
            raise ValueError("photos must name at least one photograph")
        return [self.image(f"photo{number}", photo) for number, photo in enumerate(photos, 1)]

    def pair(self, given: Pair | StrPath) -> str:
        """Return the path of a pair file."""
        if not isinstance(given, Pair):
            return _path("pair", given, "a Pair or a path")
        path = self._folder / "pair.uvpair"
        given.save(path)
        return os.fspath(path)

    def mesh(self, name: str, given: Mesh | StrPath) -> str:
        """Return the path of a mesh file."""
        if not isinstance(given, Mesh):
            return _path(name, given, "a Mesh or a path")
        path = self._folder / f"{name}.obj"
        write_obj(given, path)
        return os.fspath(path)


def _path(name: str, given: object, wanted: str) -> str:
    if isinstance(given, str | os.PathLike):
        return os.fspath(given)
    raise TypeError(f"{name} must be {wanted}, got {type(given).__name__}")


def numbers(name: str, given: ArrayLike | StrPath | None) -> str | None:
    """Spell a list of numbers; the path of a file stays as it is."""
    if given is None or isinstance(given, str | os.PathLike):
        return None if given is None else os.fspath(given)
    values = np.asarray(given, dtype=np.float64)
    if values.ndim != 1 or not np.isfinite(values).all():
        raise ValueError(f"{name} must be finite, of shape (n,), got {given!r}")
    return ",".join(repr(float(value)) for value in values)


def named_numbers(given: Mapping[str, float] | None) -> str | None:
    """Spell numbers by name."""
    if given is None:
        return None
    return ",".join(f"{name}={float(value)!r}" for name, value in given.items())


def write_obj(mesh: Mesh, path: StrPath) -> None:
    """Write a mesh as OBJ, with all digits of its numbers."""
    uv = mesh.uv.astype(np.float64)
    corners = np.stack([mesh.faces + 1, mesh.uv_faces + 1], axis=2).reshape(-1, 6)
    with open(path, "w", encoding="ascii") as file:
        np.savetxt(file, mesh.positions, "v %.9g %.9g %.9g")
        # OBJ files have v = 0 at the bottom.
        np.savetxt(file, np.stack([uv[:, 0], 1 - uv[:, 1]], axis=1), "vt %.17g %.17g")
        np.savetxt(file, corners, "f %d/%d %d/%d %d/%d")


Role = Literal["normal", "roughness", "metallic", "occlusion", "orm", "emissive"]
Filter = Literal["nearest", "bilinear", "catmull-rom", "lanczos3"]
Prefer = Literal["first", "left", "right"]
Relight = Literal["off", "soft", "full"]

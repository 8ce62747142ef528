"""Pictures of avatars."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from uvgraft._types import Images, MeshLike, Size, StrPath
from uvgraft._uvgraft import make_picture

if TYPE_CHECKING:
    from uvgraft._avatar import Avatar

Bones: TypeAlias = Mapping[str, Sequence[float]]
Pose: TypeAlias = str | Bones | Sequence[str | Bones]
Expression: TypeAlias = str | Mapping[str, float] | Iterable[str]


def render(
    avatar: Avatar | MeshLike | StrPath,
    *,
    texture: Images | None = None,
    up: Literal["y", "z", "-y", "-z"] | None = None,
    size: Size = (1024, 768),
    camera: Literal["body", "head"] = "body",
    look_at: str | Sequence[float] | None = None,
    azimuth: float = 20.0,
    elevation: float = 7.0,
    fov: float = 24.0,
    zoom: float = 1.0,
    pose: Pose | None = None,
    expression: Expression | None = None,
    clip: str | int | None = None,
    frame: float | None = None,
    background: Literal["studio", "transparent"] | str | None = None,
    unlit: bool = False,
    floor: bool = True,
    memory: int | str | None = None,
    threads: int | None = None,
) -> NDArray[np.uint8]:
    """Draw a picture of an avatar, or of a mesh with a texture, on the CPU.

    Parameters
    ----------
    avatar : Avatar, Mesh, mesh of trimesh or path
        An avatar, a GLB, VRM or glTF file of any origin, or a mesh: an object, a file, a part of
        one such as ``"me.glb#Head"``, or the target of a pair file.
    texture : image, or list of two, optional
        Shown on a mesh, which is grey without it, or in place of the colour texture of a model
        that has one only. Two are shown side by side, as before and after, each in a picture of
        `size`.
    up : {"y", "z", "-y", "-z"}, optional
        The axis of a mesh that points up. By default y.
    size : int or (int, int)
        Size of the picture in pixels: a side, or ``(height, width)``; at most 4096 a side.
    camera : {"body", "head"}
        What fills the picture.
    look_at : str or sequence of float, shape (6,), optional
        Fill the picture with a bone, by its VRM name such as ``"leftHand"``, a node, by its name,
        or a box, given by two corners x, y, z, x, y, z in metres.
    azimuth : float
        Angle around the person in degrees: 0 in front, 90 on their left.
    elevation : float
        Angle above the horizon in degrees, from -89 to 89.
    fov : float
        Vertical field of view in degrees, from 1 to 120.
    zoom : float
        Magnification, from 0.1 to 50.
    pose : str or mapping of str to (float, float, float), or a sequence of these, optional
        A pose (rest, t-pose, a-pose, stand, wave or walk), or rotations of bones about x, y and z
        in degrees: ``{"leftUpperArm": (0, 0, -40)}``. By default as the file has it.
    expression : str, or mapping of str to float, optional
        An expression or morph target, several, or their weights: ``{"blink": 0.8}``.
    clip : str or int, optional
        Animation clip, by name or number. By default the first.
    frame : float, optional
        Time in the clip in seconds. By default the clip is not played.
    background : {"studio", "transparent"} or str, optional
        Background, or its colour such as ``"#ff8000"``. By default studio, or white if unlit.
    unlit : bool
        Draw the colours of textures as they are.
    floor : bool
        Draw the floor and the shadow on it.
    memory : int or str, optional
        Bound on the memory of the process, in bytes or as in ``"500M"``: a file that could exceed
        it is refused. By default a gibibyte, and 200 times the size of the file.
    threads : int, optional
        Number of threads, 0 for one per processor; see `set_threads`.

    Returns
    -------
    ndarray of uint8, shape (height, width, 3)
        The picture, in sRGB, 0 to 255; with a transparent background ``(height, width, 4)``, alpha
        last and not premultiplied.

    Raises
    ------
    uvgraft.Error
        For a file that cannot be drawn, and arguments outside of their ranges.
    FileNotFoundError
        If the file does not exist.
    """
    return make_picture(
        {
            "avatar": avatar,
            "texture": texture,
            "up": up,
            "size": size,
            "camera": camera,
            "look_at": look_at,
            "azimuth": azimuth,
            "elevation": elevation,
            "fov": fov,
            "zoom": zoom,
            "pose": pose,
            "expression": expression,
            "clip": clip,
            "frame": frame,
            "background": background,
            "unlit": unlit,
            "floor": floor,
            "memory": memory,
            "threads": threads,
        }
    )

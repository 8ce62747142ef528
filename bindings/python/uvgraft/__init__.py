"""Transfers textures between meshes with different UV layouts.

The main steps::

    import uvgraft

    pair = uvgraft.Pair("head.obj", "body.obj", vertex_map="ids.npy")
    graft = uvgraft.Graft(pair, blend="membrane")
    body = graft.apply("face.png", "body.png")  # for any number of faces, from any thread
    uvgraft.write_image("body_with_face.png", body)

Or in one call::

    body = uvgraft.transfer("head.obj", "body.obj", "face.png", "body.png", vertex_map="ids.npy")

Textures are NumPy arrays of shape ``(height, width)`` or ``(height, width, channels)`` with 1 to 4
channels (grey, grey and alpha, RGB, RGBA; alpha is not premultiplied), row 0 at the top, with dtype
``uint8`` (0 to 255), ``uint16`` (0 to 65535) or ``float32`` (1.0 is white). ``float64`` and
``float16`` are converted to ``float32``, ``bool`` to ``uint8``: white where true. Wherever a
texture is read, a PIL image or the path of an image file will do as well. Sizes are one side in
texels, or ``(height, width)`` as in an array's shape. The interpreter's lock is released while
uvgraft works.
"""

from uvgraft._avatar import Avatar, avatar, avatar_from_photos
from uvgraft._avatar_options import AvatarOptions
from uvgraft._file_transfer import FileTransfer, TransferOptions, Transferred
from uvgraft._notebook import TextureView, show
from uvgraft._progress import Progress
from uvgraft._region import Region
from uvgraft._render import render
from uvgraft._results import EdgeGroup, Fit, Seams, SeamSteps, SkinMatch, Tone, WorstEdge
from uvgraft._roundtrip import RoundTrip, roundtrip
from uvgraft._selfie import Selfie, selfie
from uvgraft._transfer import GraftOptions, PairingOptions, transfer
from uvgraft._uvgraft import (
    BodyModel,
    Error,
    Graft,
    Mesh,
    Operator,
    Pair,
    SamplingMap,
    __version__,
    compare,
    flip,
    get_threads,
    l1,
    load,
    lpips,
    psnr,
    read_image,
    seams,
    set_threads,
    ssim,
    ssimulacra2,
    write_image,
)

__all__ = [
    "Avatar",
    "AvatarOptions",
    "BodyModel",
    "EdgeGroup",
    "Error",
    "FileTransfer",
    "Fit",
    "Graft",
    "GraftOptions",
    "Mesh",
    "Operator",
    "Pair",
    "PairingOptions",
    "Progress",
    "Region",
    "RoundTrip",
    "SamplingMap",
    "SeamSteps",
    "Seams",
    "Selfie",
    "SkinMatch",
    "TextureView",
    "Tone",
    "TransferOptions",
    "Transferred",
    "WorstEdge",
    "__version__",
    "avatar",
    "avatar_from_photos",
    "compare",
    "flip",
    "get_threads",
    "l1",
    "load",
    "lpips",
    "psnr",
    "read_image",
    "render",
    "roundtrip",
    "seams",
    "selfie",
    "set_threads",
    "show",
    "ssim",
    "ssimulacra2",
    "transfer",
    "write_image",
]

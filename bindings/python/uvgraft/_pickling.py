"""How objects are made again from their pickles."""

import numpy as np
from numpy.typing import NDArray

from uvgraft._uvgraft import Mesh


def mesh(
    positions: NDArray[np.float32],
    faces: NDArray[np.uint32],
    uv: NDArray[np.float32],
    uv_faces: NDArray[np.uint32],
    name: str,
) -> Mesh:
    """Make a mesh from its arrays."""
    return Mesh(positions, faces, uv, uv_faces, uv_origin="top-left", name=name)

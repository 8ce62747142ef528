"""Grids for ``grid_sample``, in the memory of whichever library asks."""

from __future__ import annotations

import sys
from importlib import import_module
from typing import Any

from uvgraft._uvgraft import SamplingMap


def grid(map: SamplingMap, device: Any = None, *, gutter: bool = True) -> Any:
    """Return where each texel of a map comes from.

    Parameters
    ----------
    map : SamplingMap
        The map.
    device : str, torch.device, jax.Device or jax.sharding.Sharding, optional
        Where the grid shall be.
    gutter : bool
        Whether texels of the gutter have a position.

    Returns
    -------
    ndarray, torch.Tensor or jax.Array of float32, shape (height, width, 2)
        x and y, where -1 and 1 are the *edges* of the texture; -3 where nothing is transferred. An
        array of NumPy without a device, of JAX on one of JAX, and a tensor on any other.

    Raises
    ------
    ImportError
        If ``device`` is one of PyTorch, which is not installed.
    """
    values = map._grid(gutter=gutter)
    if device is None:
        return values
    # A device of JAX can only be given by a program that has imported it.
    jax = sys.modules.get("jax")
    if jax is not None and isinstance(device, jax.Device | jax.sharding.Sharding):
        return jax.device_put(values, device)
    try:
        torch = import_module("torch")
    except ImportError as error:
        raise ImportError("device needs PyTorch: pip install 'uvgraft[torch]'") from error
    return torch.from_dlpack(values).to(device)

"""Other libraries' methods of resampling an image through a map, in process.

Each method is a function without arguments on textures already in memory. "alone" produces the whole
array of the target's size; "whole job" writes the carried texels into the base, as uvgraft's resampling
does.
"""

import cv2
import numpy as np

try:
    import torch
except ImportError:
    torch = None

try:
    import uvgraft
except ImportError:
    uvgraft = None

# Outside the source by more than any filter's footprint.
NOWHERE = -100.0


class Scene:
    """A source, a base, and a grid of source positions (u, v), NaN where no texel is carried."""

    def __init__(self, grid, source, base):
        self.grid, self.source, self.base = grid, source, base
        self.carried = ~np.isnan(grid[..., 0])
        rows, columns = (np.flatnonzero(self.carried.any(axis)) for axis in (1, 0))
        if rows.size == 0:
            raise SystemExit("the pair's map carries no texel at this size")
        # The bounding box of the carried texels, which a script would have to compute.
        self.box = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
        # OpenCV's origin is the centre of the first texel.
        self.x, self.y = (
            np.where(
                self.carried,
                grid[..., k] * np.float32(source.shape[1 - k]) - np.float32(0.5),
                NOWHERE,
            ).astype(np.float32)
            for k in (0, 1)
        )
        self.mask = self.carried.astype(np.uint8) * 255


def opencv(scene):
    """`{(name, scope, method): function}`, with several methods for some scopes."""
    ways = {}
    whole = np.s_[:, :]
    fixed = cv2.convertMaps(scene.x, scene.y, cv2.CV_16SC2)
    buffer, out = scene.base.copy(), scene.base.copy()

    def remap(maps, filter, box, into, **border):
        cv2.remap(scene.source, maps[0][box], maps[1][box], filter, dst=into[box], **border)

    def add(name, maps, filter):
        transparent = {"borderMode": cv2.BORDER_TRANSPARENT}

        def copied():
            remap(maps, filter, whole, buffer)
            cv2.copyTo(buffer, scene.mask, out)

        ways[name, "alone", "remap"] = lambda: remap(maps, filter, whole, buffer)
        ways[name, "whole job", "remap, copyTo"] = copied
        ways[name, "whole job", "transparent border"] = lambda: remap(
            maps, filter, whole, out, **transparent
        )
        ways[name, "whole job", "transparent border, within the mask's box"] = lambda: remap(
            maps, filter, scene.box, out, **transparent
        )

    # Common in scripts: -1 where no texel is carried, and a new array for each image. This close to the
    # source, OpenCV takes its slow path for edges.
    marked = [np.where(scene.carried, axis, np.float32(-1)) for axis in (scene.x, scene.y)]

    def add_script(name, filter):
        def script():
            cv2.copyTo(cv2.remap(scene.source, *marked, filter), scene.mask, out)

        ways[name, "whole job", "-1 elsewhere, new array, copyTo"] = script

    floats = (scene.x, scene.y)
    add("cv2 INTER_NEAREST", floats, cv2.INTER_NEAREST)
    add("cv2 INTER_NEAREST, fixed point", fixed, cv2.INTER_NEAREST)
    add("cv2 INTER_LINEAR", floats, cv2.INTER_LINEAR)
    add("cv2 INTER_LINEAR, fixed point", fixed, cv2.INTER_LINEAR)
    add("cv2 INTER_CUBIC", floats, cv2.INTER_CUBIC)
    add("cv2 INTER_CUBIC, fixed point", fixed, cv2.INTER_CUBIC)
    add("cv2 INTER_LANCZOS4", floats, cv2.INTER_LANCZOS4)
    add_script("cv2 INTER_LINEAR, as in scripts", cv2.INTER_LINEAR)
    add_script("cv2 INTER_CUBIC, as in scripts", cv2.INTER_CUBIC)
    return ways


def pytorch(scene):
    """Like `opencv`; empty if PyTorch is not installed."""
    if torch is None:
        return {}
    ways = {}
    whole = np.s_[:, :]
    positions = np.where(scene.carried[..., None], 2 * scene.grid - 1, NOWHERE).astype(np.float32)
    positions = torch.from_numpy(positions)
    source, out = torch.from_numpy(scene.source), torch.from_numpy(scene.base.copy())
    carried = torch.from_numpy(scene.carried)[..., None]
    floats = source.permute(2, 0, 1)[None].float().contiguous()

    def sample(image, mode, box):
        grid = positions[box][None]
        return torch.nn.functional.grid_sample(image, grid, mode=mode, align_corners=False)

    def job(mode, box):
        image = source.permute(2, 0, 1)[None].float()
        values = sample(image, mode, box)[0].round_().clamp_(0, 255).byte().permute(1, 2, 0)
        torch.where(carried[box], values, out[box], out=out[box])

    def add(mode):
        name = f"torch grid_sample {mode}"
        ways[name, "alone", "grid_sample of floats"] = lambda: sample(floats, mode, whole)
        ways[name, "whole job", "where"] = lambda: job(mode, whole)
        ways[name, "whole job", "where, within the mask's box"] = lambda: job(mode, scene.box)

    add("nearest")
    add("bilinear")
    add("bicubic")
    return ways


def python_package(scene, pair, reverse, filters):
    """uvgraft from Python, which copies the source as its library does; empty if it is not installed."""
    if uvgraft is None:
        return {}
    ways = {}
    pair = uvgraft.Pair.load(pair)
    out = scene.base.copy()

    def add(name):
        graft = uvgraft.Graft(pair, reverse=reverse, filter=name)
        new = "new array"
        ways[f"uvgraft from Python, {name}", "whole job", "in place"] = lambda: graft.apply(
            scene.source, out, out=out
        )
        ways[f"uvgraft from Python, {name}", "whole job", new] = lambda: graft.apply(
            scene.source, scene.base
        )

    for name in filters:
        add(name)
    return ways


def versions():
    found = {"cv2": cv2.__version__, "numpy": np.__version__}
    return found | ({"torch": torch.__version__} if torch else {})


def set_threads(threads):
    cv2.setNumThreads(threads)
    if torch:
        torch.set_num_threads(threads)
    if uvgraft:
        uvgraft.set_threads(threads)

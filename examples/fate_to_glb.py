"""Turn what FATE baked from a video of a head into an animated avatar, and draw it.

FATE's textures are in FLAME's layout, so the pair leads from FLAME to the body::

    uvgraft pair flame.obj smplx.obj --vertex-map SMPL-X__FLAME_vertex_ids.npy -o pair.uvpair
    python fate_to_glb.py fate_workspace pair.uvpair body.png SMPLX_NEUTRAL.npz -o me.glb

``demo`` in place of the model file is the built-in figure, with the pair of ``uvgraft demo``.
"""

import argparse
from pathlib import Path

import uvgraft


def build(workspace: Path, pair: Path, onto: Path, body: str, output: Path) -> uvgraft.Avatar:
    """Build the avatar, write it, and draw its head beside it."""
    # The workspace's own opacity says which texels the video showed; the rest is left to the body.
    avatar = uvgraft.avatar(pair, workspace, onto=onto, body=body, tone="source", output=output)
    print(avatar.report)

    picture = avatar.render(camera="head", size=(512, 512))
    uvgraft.write_image(output.with_suffix(".png"), picture)
    return avatar


def main(arguments: list[str] | None = None) -> uvgraft.Avatar:
    """Read the arguments."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("workspace", type=Path, help="folder with baking*/ inside")
    parser.add_argument("pair", type=Path, help="pair file from the head to the body")
    parser.add_argument("onto", type=Path, help="texture of the body")
    parser.add_argument("body", help="model file, or demo")
    parser.add_argument("-o", "--output", type=Path, default=Path("avatar.glb"))
    given = parser.parse_args(arguments)
    return build(given.workspace, given.pair, given.onto, given.body, given.output)


if __name__ == "__main__":
    main()

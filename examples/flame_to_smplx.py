"""Put the texture of a head onto the texture of a body.

With files of your own, such as FLAME's and SMPL-X's, and the table of corresponding vertices that
comes with them::

    python flame_to_smplx.py flame.obj smplx.obj face.png body.png \
        --vertex-map SMPL-X__FLAME_vertex_ids.npy -o body_with_face.png

Without arguments it runs on the data of ``uvgraft demo``.
"""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import uvgraft


def transfer(head: Path, body: Path, face: Path, base: Path, *, vertex_map: Path | None, out: Path):
    """Link the meshes, transfer the face, and report how visible its boundary is."""
    # Linking is done once; `pair.save` keeps it.
    pair = uvgraft.Pair(head, body, vertex_map=vertex_map)
    print(pair)

    # The graft serves any number of faces. With tone="source", the body's skin takes on the face's.
    graft = uvgraft.Graft(pair, blend="membrane", tone="source")
    texture = graft.apply(face, base)
    uvgraft.write_image(out, texture)

    before = uvgraft.seams(graft, uvgraft.Graft(pair).apply(face, base)).rim.delta_e
    after = uvgraft.seams(graft, texture).rim.delta_e
    if before and after:
        print(f"colour step at the boundary, median ΔE: {before.median:.2f} to {after.median:.2f}")
    print(f"wrote {out}, {texture.shape[1]} x {texture.shape[0]} texels")
    return before, after


def main(arguments: list[str] | None = None):
    """Read the arguments; without any, make the data of the built-in example."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    for name in ("head", "body", "face", "base"):
        parser.add_argument(name, type=Path, nargs="?")
    parser.add_argument("--vertex-map", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=Path("body_with_face.png"))
    given = parser.parse_args(arguments)
    if given.base is not None:
        files = (given.head, given.body, given.face, given.base)
        return transfer(*files, vertex_map=given.vertex_map, out=given.output)
    if given.head is not None:
        parser.error("either all of head, body, face and base, or none")
    with tempfile.TemporaryDirectory() as folder:
        words = [sys.executable, "-m", "uvgraft", "demo", "--size", "512", "-o", folder]
        subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
        made = [Path(folder, f) for f in ("head.obj", "body.obj", "face.png", "body_base.png")]
        return transfer(*made, vertex_map=Path(folder, "head_to_body.npy"), out=given.output)


if __name__ == "__main__":
    main()

"""Fit the texture of a head by gradient descent through a transfer.

Given is the texture of a body, wanted the texture of the head from which the transfer makes it
again. To sample the body's texture, as the transfer back does, is not the best answer: some of its
detail is between the samples. A loss on the *result* of the transfer finds a better one, and can be
anything that PyTorch differentiates. For squared differences, ``Graft.fit`` finds the least-squares
solution directly, which no other way to the same aim surpasses.

    python fit_by_gradient_descent.py                       # a small sheet that needs no files
    python fit_by_gradient_descent.py head_to_body.uvpair body.png --size 512 -o head.png
"""

import argparse

import numpy as np
import torch

import uvgraft
import uvgraft.torch


def main() -> None:
    """Fit, and print how well the body's texture is met."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("pair", nargs="?", help="pair file, from the head to the body")
    parser.add_argument("body", nargs="?", help="texture of the body")
    parser.add_argument("--size", type=int, default=96, help="side of the head's texture")
    parser.add_argument("--steps", type=int, default=200)
    parser.add_argument("-o", "--output", help="write the head's texture to this file")
    options = parser.parse_args()
    if (options.pair is None) != (options.body is None):
        parser.error("pair and body go together")
    if options.pair is None:
        pair, body = synthetic()
    else:
        pair = uvgraft.Pair.load(options.pair)
        body = uvgraft.read_image(options.body)[..., :3]
        body = body.astype(np.float32) / np.iinfo(body.dtype).max

    black = np.zeros((options.size, options.size, 3), np.float32)
    back = uvgraft.Graft(pair, reverse=True, filter="bilinear")
    sampled = back.apply(body, black)
    # The defaults stop early and smooth what hardly shows; here the limit itself is of interest.
    plain = {"min_gain": 0.0, "regularization": 0.0, "smoothness": 0.0}
    fitted = back.fit(body, black, steps=100, **plain).texture

    forth = uvgraft.Graft(pair, filter="bilinear", gutter=0)
    transfer = uvgraft.torch.Transfer(forth, source_size=options.size, size=body.shape[:2])
    descended = descend(transfer, planes(sampled), planes(body), options.steps)

    print("PSNR of the body's texture, made again from the head's:")
    for name, head in (
        ("sampled", planes(sampled)),
        ("gradient descent", descended),
        ("least squares", planes(fitted)),
    ):
        print(f"  {name:16} {psnr(transfer, head, planes(body)):.2f} dB")
    if options.output:
        texels = descended.movedim(0, -1).clamp(0, 1).numpy()
        uvgraft.write_image(options.output, np.rint(texels * 255).astype(np.uint8))


def descend(
    transfer: uvgraft.torch.Transfer, start: torch.Tensor, wanted: torch.Tensor, steps: int
) -> torch.Tensor:
    """Minimise the mean square difference over the texels that the transfer reaches."""
    head = start.clone().requires_grad_()
    optimizer = torch.optim.Adam([head], lr=0.01)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, steps)
    covered = transfer.coverage > 0
    for _ in range(steps):
        optimizer.zero_grad()
        loss = (transfer(head) - wanted)[:, covered].square().mean()
        loss.backward()
        optimizer.step()
        schedule.step()
    return head.detach()


def psnr(transfer: uvgraft.torch.Transfer, head: torch.Tensor, wanted: torch.Tensor) -> float:
    """Compare what the transfer makes of a head with what is wanted, where it reaches."""
    difference = (transfer(head) - wanted)[:, transfer.coverage > 0]
    return float(-10 * torch.log10(difference.square().mean()))


def planes(texture: np.ndarray) -> torch.Tensor:
    """Return a texture with its channels first."""
    return torch.from_numpy(np.ascontiguousarray(texture)).movedim(-1, 0).contiguous()


def synthetic(cells: int = 12, size: int = 128) -> tuple[uvgraft.Pair, np.ndarray]:
    """Make a curved sheet in two layouts, and a texture with fine detail for the second."""
    side = np.linspace(0, 1, cells + 1)
    flat = np.stack([axis.ravel() for axis in np.meshgrid(side, side)], axis=1)
    positions = np.column_stack([flat, 0.1 * np.sin(3 * flat[:, 0])])
    corner = np.arange(cells * (cells + 1)).reshape(cells, cells + 1)[:, :-1].ravel()
    below = corner + cells + 1
    faces = np.concatenate(
        [
            np.column_stack([corner, corner + 1, below]),
            np.column_stack([corner + 1, below + 1, below]),
        ]
    )
    turned = 0.5 + (flat - 0.5) @ np.array([[0.55, 0.35], [-0.35, 0.55]])
    head = uvgraft.Mesh(positions, faces, 0.05 + 0.9 * flat, uv_origin="top-left", name="head")
    body = uvgraft.Mesh(positions, faces, turned, uv_origin="top-left", name="body")
    pair = uvgraft.Pair(head, body, vertex_map=np.arange(len(positions)))
    y, x = np.mgrid[:size, :size] / size
    texture = [0.5 + 0.4 * np.sin(tone * x + 9 * y) * np.cos(23 * y) for tone in (20, 45, 70)]
    return pair, np.stack(texture, axis=-1).astype(np.float32)


if __name__ == "__main__":
    main()

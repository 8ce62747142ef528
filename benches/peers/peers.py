"""Compares uvgraft with other libraries that resample an image through a map, in one run.

    make bench-peers
    make bench-peers PEERS="--pair my.uvpair --threads 4"

In process: OpenCV's remap, PyTorch's grid_sample and uvgraft's own Python package, if they are
installed, against what `uvgraft bench` measures. File to file: cv2_transfer.py against `uvgraft transfer`. All take turns, with the same number
of threads and the same map. Prints Markdown, and writes JSON next to the images that it makes.
"""

import argparse
import itertools
import json
import os
import pathlib
import statistics
import subprocess
import sys

try:
    import cv2
    import numpy as np
    import PIL.Image
except ImportError as error:
    sys.exit(f"{error}: pip install -r benches/peers/requirements.txt, or run make bench-peers")

import images
import resamplers
import tables

HERE = pathlib.Path(__file__).resolve().parent
DIRECTIONS = {"forward": [], "reverse": ["--reverse"]}
KINDS = ["smooth", "detailed"]
# Pillow filters nearly all rows of a PNG by Paeth's prediction, OpenCV by the texel to the left.
WRITERS = ["OpenCV", "Pillow"]
# uvgraft's closest filter, by a part of the other library's method name.
COUNTERPART = {
    "grid_sample nearest": "nearest",
    "grid_sample bilinear": "bilinear",
    "grid_sample bicubic": "catmull-rom",
    "INTER_NEAREST": "nearest",
    "INTER_LINEAR": "bilinear",
    "INTER_CUBIC": "catmull-rom",
    "INTER_LANCZOS4": "lanczos3",
}
FILTERS = ["nearest", "bilinear", "catmull-rom", "lanczos3"]
# From Python a source stays as it is, so the library's job is the one with a copy of it.
COUNTERPART |= {f"from Python, {name}": f"{name}, source kept" for name in FILTERS}


def main():
    args = arguments()
    args.work.mkdir(parents=True, exist_ok=True)
    resamplers.set_threads(args.threads)
    pair = args.pair or own_pair(args)
    setups = {name: Setup(args, pair, name) for name in DIRECTIONS}
    report = {"versions": resamplers.versions(), "threads": args.threads, "runs": args.runs}
    report |= {"pair": str(pair), "source_size": args.source_size, "target_size": args.target_size}
    # First, while no arrays occupy memory.
    report["files"] = files(args, pair, setups)
    report["differences"] = differences(setups)
    report["resample"] = resample(args, pair, setups, report)
    (args.work / "peers.json").write_text(json.dumps(report, indent=1) + "\n")
    print(markdown(report))
    print(f"JSON: {args.work / 'peers.json'}")


def arguments():
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", HERE.parents[1] / "target")).resolve()
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument(
        "--pair",
        type=pathlib.Path,
        help="pair file [default: of UVGRAFT_DATA's meshes, or the demo's]",
    )
    parser.add_argument(
        "--uvgraft", type=pathlib.Path, default=target / "release/uvgraft", help="the program"
    )
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--runs", type=int, default=5, help="how often each is measured")
    parser.add_argument("--source-size", type=int, default=2048)
    parser.add_argument("--target-size", type=int, default=4096)
    parser.add_argument(
        "--work", type=pathlib.Path, default=target / "peers", help="folder for what is made"
    )
    args = parser.parse_args()
    if not args.uvgraft.is_file():
        parser.error(f"there is no {args.uvgraft}: cargo build --release -p uvgraft-cli")
    if args.pair and not args.pair.is_file():
        parser.error(f"there is no pair file {args.pair}")
    if min(args.threads, args.runs, args.source_size, args.target_size) < 1:
        parser.error("threads, runs and sizes have to be 1 or more")
    return args


def run(*command):
    """The output of a command. If it fails, only its own message is shown."""
    done = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, text=True)
    if done.returncode != 0:
        sys.exit(f"failed: {' '.join(str(word) for word in command)}")
    return done.stdout


def own_pair(args):
    """FLAME and SMPL-X if available, else the synthetic pair of the demo."""
    data = os.environ.get("UVGRAFT_DATA")
    if not data:
        run(args.uvgraft, "demo", "--size", 64, "--output", args.work / "demo")
        return args.work / "demo/head_to_body.uvpair"
    data = pathlib.Path(data)
    meshes = [data / "flame_head_template.obj", data / "smplx_addon.obj"]
    pair = args.work / "flame_to_smplx.uvpair"
    vertex_map = ["--vertex-map", data / "smplx_flame_vertex_ids.npy"]
    run(args.uvgraft, "pair", *meshes, *vertex_map, "-o", pair)
    return pair


class Setup:
    """One direction: its sizes, and the files that both programs read."""

    def __init__(self, args, pair, direction):
        self.direction, self.options = direction, DIRECTIONS[direction]
        self.sides = [args.source_size, args.target_size][:: 1 if direction == "forward" else -1]
        self.work = args.work
        self.grid_file = args.work / f"{direction}-grid.npy"
        size = ["--size", self.sides[1], "-o", self.grid_file]
        run(args.uvgraft, "map", pair, *self.options, *size)
        # Without the gutter, to compare the results of both programs.
        self.inner_file = args.work / f"{direction}-inner.npy"
        size[-1] = self.inner_file
        run(args.uvgraft, "map", pair, *self.options, *size, "--gutter", 0)
        for kind in KINDS:
            written = zip(self.sides, (1, 2), *(self.images(kind, writer) for writer in WRITERS))
            for side, seed, by_opencv, by_pillow in written:
                image = images.image(kind, side, seed)
                cv2.imwrite(str(by_opencv), image)
                PIL.Image.fromarray(image[..., ::-1]).save(by_pillow)
        scene = self.scene("smooth")
        self.arrays = []
        for name, array in (("x", scene.x), ("y", scene.y), ("mask", scene.mask)):
            self.arrays.append(args.work / f"{direction}-{name}.npy")
            np.save(self.arrays[-1], array)

    def images(self, kind, writer="OpenCV"):
        """The files of the source and the base."""
        names = zip(("source", "base"), self.sides)
        return [self.work / f"{kind}-{what}-{side}-{writer}.png" for what, side in names]

    def scene(self, kind):
        source, base = (cv2.imread(str(path)) for path in self.images(kind))
        return resamplers.Scene(np.load(self.grid_file), source, base)

    def result(self, kind, program):
        return self.work / f"{kind}-{self.direction}-{program}.png"


def files(args, pair, setups):
    """Whole processes, taking turns."""
    os.environ["RAYON_NUM_THREADS"] = str(args.threads)
    rows = []
    for setup in setups.values():
        for kind, writer in itertools.product(KINDS, WRITERS):
            source, base = setup.images(kind, writer)
            out = {name: setup.result(kind, name) for name in ("uvgraft", "cv2")}
            script = [sys.executable, HERE / "cv2_transfer.py", source, base, *setup.arrays]
            transfer = [args.uvgraft, "transfer", pair, source, "--onto", base, *setup.options]
            commands = {
                "cv2": [*script, args.threads, out["cv2"]],
                "uvgraft": [*transfer, "--filter", "bilinear", "-o", out["uvgraft"]],
                "imports": [sys.executable, "-c", "import cv2, numpy"],
            }
            taken = {name: [] for name in commands}
            for turn in range(args.runs + 1):
                for name, command in commands.items():
                    measured = json.loads(run(sys.executable, HERE / "measured.py", *command))
                    # The first turn only warms the caches.
                    if turn > 0:
                        taken[name].append(measured)
            for name, runs in taken.items():
                row = {"direction": setup.direction, "image": kind, "writer": writer}
                row |= {"program": name, "runs": runs}
                for key in ("wall_s", "cpu_s", "peak_bytes"):
                    row[key] = spread([run[key] for run in runs])
                if name in out:
                    row["output_bytes"] = out[name].stat().st_size
                rows.append(row)
    return rows


def differences(setups):
    """Differences in levels between the results of both programs, well inside the islands of both
    layouts: around the source's islands uvgraft reads its padding, and OpenCV the source's texels."""
    rows = []
    inner = {name: np.load(setup.inner_file) for name, setup in setups.items()}
    # Wider than a filter's footprint at a sixfold minification.
    window = np.ones((17, 17), np.uint8)
    inside = {
        name: cv2.erode((~np.isnan(grid[..., 0])).astype(np.uint8), window, borderValue=0)
        for name, grid in inner.items()
    }
    for (name, setup), other in zip(setups.items(), reversed(setups)):
        side = setup.sides[0]
        x, y = (np.nan_to_num(inner[name][..., k] * side - 0.5, nan=-100) for k in (0, 1))
        x, y = x.astype(np.float32), y.astype(np.float32)
        read_inside = cv2.remap(inside[other], x, y, cv2.INTER_NEAREST)
        compared = (inside[name] & read_inside) > 0
        # Source texels that a target texel spans; uvgraft averages from 1.5. The maximum over the
        # neighbours, since steps across a triangle's edge belong to neither side.
        steps = [np.diff(inner[name], axis=axis, append=np.nan) * side for axis in (0, 1)]
        span = np.maximum(*(np.hypot(step[..., 0], step[..., 1]) for step in steps))
        span = cv2.dilate(np.nan_to_num(span), np.ones((5, 5), np.uint8))
        for kind in KINDS:
            ours, theirs = (
                cv2.imread(str(setup.result(kind, name))) for name in ("uvgraft", "cv2")
            )
            levels = cv2.absdiff(ours, theirs)
            for where, texels in (("all", compared), ("not minified", compared & (span < 1.4))):
                found = levels[texels].astype(np.float64)
                row = {"direction": setup.direction, "image": kind, "texels": where}
                if found.size:
                    row |= {"count": len(found), "max": found.max(), "mean": found.mean()}
                    rows.append(row)
    return rows


def resample(args, pair, setups, report):
    """The resampling of all libraries, taking turns."""
    scenes = {name: setup.scene("detailed") for name, setup in setups.items()}
    ways = {}
    for direction, scene in scenes.items():
        found = resamplers.opencv(scene) | resamplers.pytorch(scene)
        found |= resamplers.python_package(scene, pair, direction == "reverse", FILTERS)
        ways |= {(direction, *way): work for way, work in found.items()}
    bench = [args.uvgraft, "bench", pair, "--both", "--stage", "resample,apply", "--runs", 1, "--json"]
    bench += ["--filter", ",".join(FILTERS)]
    bench += ["--source-size", args.source_size, "--size", args.target_size]
    bench += ["--threads", args.threads]
    taken = {}
    for turn in range(args.runs + 1):
        found = json.loads(run(*bench))
        report["versions"]["uvgraft"], report["cpu"] = found["uvgraft"], found["cpu"]
        for row in found["stages"]:
            kept = ", source kept" if row["stage"] == "apply" else ""
            way = (row["direction"], f"uvgraft {row['with']}{kept}", "whole job", "–")
            if turn > 0:
                taken.setdefault(way, []).extend(row["times_ms"])
        for way, work in ways.items():
            ticks = cv2.getTickCount()
            work()
            ms = (cv2.getTickCount() - ticks) / cv2.getTickFrequency() * 1e3
            # The first turn only warms the caches.
            if turn > 0:
                taken.setdefault(way, []).append(ms)
    keys = ("direction", "name", "what", "way")
    return [dict(zip(keys, way), ms=spread(times), times_ms=times) for way, times in taken.items()]


def spread(values):
    return {"median": statistics.median(values), "min": min(values), "max": max(values)}


def markdown(report):
    sizes = f"{report['source_size']}² → {report['target_size']}² and back"
    versions = ", ".join(f"{name} {version}" for name, version in report["versions"].items())
    head = f"{report['cpu']}, {report['threads']} threads, {sizes}; {versions}; medians of {report['runs']}"
    parts = [head, "## Resample in process", tables.resample_table(report["resample"], COUNTERPART)]
    parts += ["## File to file, bilinear", tables.files_table(report["files"])]
    parts += [tables.writers_line(report["files"])]
    parts += [
        "## How far apart the bilinear results are, in levels of 255",
        tables.differences_table(report["differences"]),
    ]
    return "\n\n".join(parts) + "\n"


if __name__ == "__main__":
    main()

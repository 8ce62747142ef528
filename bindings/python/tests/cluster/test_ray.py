"""Ray writes what the command writes, whatever is killed meanwhile, in bounded memory."""

import json
import os
import tarfile
from statistics import median

import pytest
from conftest import GOOD, check_reports, contents, paint, run_command
from processes import images, kill, kill_with_descendants, recorded, reports_of, start, wait_for

pytestmark = pytest.mark.cluster
pa = pytest.importorskip("pyarrow")
pq = pytest.importorskip("pyarrow.parquet")
uvgraft_ray = pytest.importorskip("uvgraft.ray")

# What Ray hands out at a time: an eighth of a worker's share of 200 textures.
BLOCK = 200 // 16


def test_same_bytes_as_the_command(ray_cluster, faces, options, wanted, output):
    def run():
        arguments = {**options, "output": output, "concurrency": 2, "memory": 300 << 20}
        return uvgraft_ray.transfer(str(faces), **arguments).take_all()

    check_reports(run(), wanted, "written")
    assert contents(output) == wanted
    check_reports(run(), wanted, "up to date")
    # The command takes the records over.
    before = {name: os.stat(output / name).st_mtime_ns for name in wanted}
    run_command(faces, options, output, "--skip-existing", check=False)
    assert {name: os.stat(output / name).st_mtime_ns for name in wanted} == before
    # An output that was damaged is made again, and no other.
    (output / "007.png").write_bytes(b"damaged")
    again = [report["output"] for report in run() if report["status"] == "written"]
    assert again == [str(output / "007.png")]
    assert contents(output) == wanted


def test_bytes_tables_and_archives(ray_cluster, faces, options, wanted, output):
    names = sorted(wanted)[:12]
    paths = [str(faces / name) for name in names]
    pq.write_table(pa.table({"path": paths, "other": paths}), output.parent / "faces.parquet")
    with tarfile.open(output.parent / "faces.tar", "w") as archive:
        for path, name in zip(paths, names, strict=True):
            archive.add(path, name)
        archive.add(__file__, "notes.txt")
    sources = {
        "table": str(output.parent / "faces.parquet"),
        "archive": str(output.parent / "faces.tar"),
        "bytes": ray_cluster.data.read_binary_files(paths, include_paths=True),
        "list": paths,
    }
    for name, source in sources.items():
        arguments = {**options, "output": output / name, "concurrency": 1, "memory": 300 << 20}
        reports = uvgraft_ray.transfer(source, **arguments).take_all()
        assert [report["status"] for report in reports] == ["written"] * len(names), name
        assert contents(output / name) == {name: wanted[name] for name in names}


def test_options_are_checked_when_actors_start(ray_cluster, faces, options, output):
    arguments = {**options, "onto": "missing.png", "output": output, "concurrency": 1}
    with pytest.raises(ray_cluster.exceptions.RayError, match=r"missing\.png"):
        uvgraft_ray.transfer(str(faces), **arguments).take_all()


def drive(faces, output, options):
    pids = output.parent / "pids"
    pids.mkdir(exist_ok=True, parents=True)
    return pids, start("ray_driver.py", faces, output, pids, json.dumps(options))


def test_a_killed_worker_costs_nothing(faces, options, wanted, output):
    pids, driver = drive(faces, output, options)
    wait_for(lambda: len(images(output)) >= 20)
    killed = int(next(pids.iterdir()).name)
    kill(killed)
    reports = reports_of(driver)
    assert reports is not None
    # The block that it left counts as up to date as far as it had come.
    statuses = [report["status"] for report in reports]
    check_reports(
        [it | {"status": it["status"].replace("up to date", "written")} for it in reports],
        wanted,
        "written",
    )
    assert statuses.count("up to date") <= BLOCK
    assert contents(output) == wanted
    assert len(list(pids.iterdir())) > 2, "Ray did not start another worker"


def test_a_killed_driver_goes_on_where_it_stopped(faces, options, wanted, output):
    _, driver = drive(faces, output, options)
    wait_for(lambda: len(images(output)) >= 20)
    kill_with_descendants(driver)
    before = recorded(output)
    assert 0 < len(before) < GOOD
    # What there is, is whole.
    assert contents(output).items() <= wanted.items()
    _, driver = drive(faces, output, options)
    reports = reports_of(driver)
    assert reports is not None
    assert contents(output) == wanted
    # What was recorded is not done again, and everything else is: none missing, none twice.
    written = [os.path.basename(it["output"]) for it in reports if it["status"] == "written"]
    assert sorted(before + written) == sorted(wanted)
    _, driver = drive(faces, output, options)
    check_reports(reports_of(driver), wanted, "up to date")


def test_memory_is_bounded(ray_cluster, options, output):
    """Four times as much as the object store holds goes through it, and workers stay small."""

    paint(output.parent / "face.png", 1024, 1)
    face = (output.parent / "face.png").read_bytes()
    count = 4 * (150 << 20) // len(face)

    def load(batch):
        size = len(batch["id"])
        return pa.table({"bytes": [face] * size, "name": [f"{it}.png" for it in batch["id"]]})

    dataset = ray_cluster.data.range(count, override_num_blocks=count // 8)
    # With other resources than the actors have, it is a step of its own, whose blocks are stored.
    dataset = dataset.map_batches(load, batch_size=8, num_cpus=0.5)

    class Measured(uvgraft_ray.Transfer):
        def __call__(self, batch):
            table = super().__call__(batch)
            # Of the worker's own: the pages of the object store that it has read are Ray's.
            with open("/proc/self/status") as status:
                held = next(int(line.split()[1]) for line in status if line.startswith("RssAnon"))
            return table.append_column("held_kb", pa.array([held] * len(table)))

    arguments = {**options, "output": str(output), "size": 256, "resume": None}
    held = [
        report["held_kb"] * 1024
        for report in dataset.map_batches(
            Measured,
            fn_constructor_kwargs=arguments,
            batch_format="pyarrow",
            batch_size=8,
            num_cpus=1,
            compute=ray_cluster.data.ActorPoolStrategy(size=1),
        ).iter_rows()
    ]
    assert len(held) == count
    assert len(images(output)) == count
    # An allocator keeps the most that a batch of eight needed, and on another thread once more:
    # medians of whole thirds pass over such steps, and half of each image is over the limit.
    third = count // 3
    growth = median(held[-third:]) - median(held[third:-third])
    assert growth < third * len(face) / 2, f"{growth} bytes over {third} textures of {len(face)}"

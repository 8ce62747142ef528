"""Daft writes what the command writes, whatever is killed meanwhile."""

import json
import os
import tarfile

import pytest
from conftest import check_reports, contents
from processes import images, kill, kill_with_descendants, recorded, reports_of, start, wait_for

pytestmark = pytest.mark.cluster
daft = pytest.importorskip("daft")
pa = pytest.importorskip("pyarrow")
pq = pytest.importorskip("pyarrow.parquet")
uvgraft_daft = pytest.importorskip("uvgraft.daft")


def test_same_bytes_as_the_command(faces, options, wanted, output):
    def run():
        arguments = {**options, "output": output, "concurrency": 2}
        return uvgraft_daft.transfer(faces, **arguments).to_pylist()

    check_reports(run(), wanted, "written")
    assert contents(output) == wanted
    check_reports(run(), wanted, "up to date")
    (output / "007.png").write_bytes(b"damaged")
    again = [report["output"] for report in run() if report["status"] == "written"]
    assert again == [str(output / "007.png")]
    assert contents(output) == wanted


def test_bytes_tables_patterns_and_archives(faces, options, wanted, output):
    names = [f"00{index}.png" for index in range(10)]
    paths = [str(faces / name) for name in names]
    pq.write_table(pa.table({"path": paths, "other": paths}), output.parent / "faces.parquet")
    with tarfile.open(output.parent / "faces.tar", "w") as archive:
        for path, name in zip(paths, names, strict=True):
            archive.add(path, name)
    frame = daft.from_pydict({"url": paths, "name": names})
    sources = {
        "table": str(output.parent / "faces.parquet"),
        "pattern": str(faces / "00*.png"),
        "archive": str(output.parent / "faces.tar"),
        "bytes": frame.select(daft.col("url").download().alias("bytes"), daft.col("name")),
    }
    for name, source in sources.items():
        arguments = {**options, "output": output / name, "concurrency": 1}
        reports = uvgraft_daft.transfer(source, **arguments).to_pylist()
        assert [report["status"] for report in reports] == ["written"] * len(names), name
        assert contents(output / name) == {name: wanted[name] for name in names}


def drive(faces, output, options):
    pids = output.parent / "pids"
    pids.mkdir(exist_ok=True, parents=True)
    return pids, start("daft_driver.py", faces, output, pids, json.dumps(options))


@pytest.mark.parametrize("victim", ["worker", "driver"])
def test_what_was_killed_goes_on_where_it_stopped(victim, faces, options, wanted, output):
    pids, driver = drive(faces, output, options)
    wait_for(lambda: len(images(output)) >= 20)
    if victim == "driver":
        kill_with_descendants(driver)
    else:
        kill(int(next(pids.iterdir()).name))
        # Daft does not replace its processes: the query fails, and the next one goes on.
        assert reports_of(driver) is None
    before = recorded(output)
    assert 0 < len(before) < len(wanted)
    assert contents(output).items() <= wanted.items()
    _, driver = drive(faces, output, options)
    reports = reports_of(driver)
    assert reports is not None
    assert contents(output) == wanted
    written = [os.path.basename(it["output"]) for it in reports if it["status"] == "written"]
    assert sorted(before + written) == sorted(wanted)

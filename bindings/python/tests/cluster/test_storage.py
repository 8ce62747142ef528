"""Batches without an engine: names, records and object storage."""

import json
import os
import pickle
import re
from pathlib import Path

import pytest
from conftest import check_reports, contents, run_command

pytestmark = pytest.mark.cluster
fs = pytest.importorskip("pyarrow.fs")
fsspec = pytest.importorskip("fsspec")

from uvgraft._files import LocalFiles  # noqa: E402
from uvgraft._records import SEGMENT, Record, Records  # noqa: E402
from uvgraft._remote import RemoteFiles  # noqa: E402
from uvgraft._sources import check_distinct, find  # noqa: E402
from uvgraft.batch import BatchTransfer  # noqa: E402

PAGE = Path(__file__).resolve().parents[4] / "docs" / "src" / "scale.md"


def rows(faces):
    return [{"path": str(path)} for path in sorted(faces.iterdir())]


def run(transfer, some):
    return [report._asdict() for report in transfer.run(some)]


def test_a_loop_writes_the_same_bytes(faces, options, wanted, output):
    transfer = BatchTransfer(**options, output=output)
    check_reports(run(transfer, rows(faces)), wanted, "written")
    assert contents(output) == wanted
    again = pickle.loads(pickle.dumps(transfer))
    check_reports(run(again, rows(faces)), wanted, "up to date")


@pytest.mark.skipif(not PAGE.is_file(), reason="the book is not beside the tests")
def test_the_loop_in_the_book(faces, options, wanted, output, monkeypatch):
    blocks = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(), re.MULTILINE | re.DOTALL)
    (loop,) = (block for block in blocks if "JOB_COMPLETION_INDEX" in block)
    output.mkdir(parents=True)
    paths = [str(path) for path in sorted(faces.iterdir())]
    (output.parent / "faces.txt").write_text("\n".join(paths))
    (output.parent / "reports").mkdir()
    for example, real in {
        "/shared/head_to_body.uvpair": options["pair"],
        '"/shared/body.png"': f'"{options["onto"]}", size=512, blend="feather"',
        "s3://bodies/2024": str(output),
        "1000": "2",
        "/shared/": f"{output.parent}/",
    }.items():
        loop = loop.replace(example, real)
    reports = []
    for shard in (0, 1):
        monkeypatch.setenv("JOB_COMPLETION_INDEX", str(shard))
        exec(compile(loop, "scale.md", "exec"), {})
        lines = (output.parent / "reports" / f"{shard}.jsonl").read_text().splitlines()
        assert len(lines) == len(paths) // 2
        reports += map(json.loads, lines)
    check_reports(reports, wanted, "written")
    assert contents(output) == wanted


def test_records_of_the_command_count(faces, options, wanted, output):
    run_command(faces, options, output, "--skip-existing", check=False)
    check_reports(run(BatchTransfer(**options, output=output), rows(faces)), wanted, "up to date")
    # By size they do not: the command does not record it.
    by_size = BatchTransfer(**options, output=output, resume="size")
    check_reports(run(by_size, rows(faces)), wanted, "written")
    by_size = BatchTransfer(**options, output=output, resume="size")
    found = run(by_size, rows(faces))
    # Neither sources nor outputs are read, so nobody sees that sources are broken.
    assert [it["status"] for it in found if "bad" not in it["source"]] == ["up to date"] * len(
        wanted
    )
    (output / "003.png").write_bytes(b"cut")
    found = run(BatchTransfer(**options, output=output, resume="size"), rows(faces)[:10])
    assert [it["status"] for it in found].count("written") == 1


def test_changed_options_and_sources_are_noticed(faces, options, wanted, output):
    some = rows(faces)[:3]
    assert {it["status"] for it in run(BatchTransfer(**options, output=output), some)} == {
        "written"
    }
    other = {**options, "gutter": 3}
    for resume in ("content", "size"):
        found = run(BatchTransfer(**other, output=output, resume=resume), some)
        assert {it["status"] for it in found} == {
            "written" if resume == "content" else "up to date"
        }
    data = (faces / "005.png").read_bytes()
    found = run(BatchTransfer(**other, output=output), [{"bytes": data, "name": "000.png"}])
    assert [it["status"] for it in found] == ["written"]


@pytest.mark.parametrize("place", ["memory://bucket/bodies", "local://{folder}", "filesystem"])
def test_object_storage(place, faces, options, wanted, output):
    filesystem = None
    if place == "filesystem":
        output.mkdir()
        filesystem = fs.SubTreeFileSystem(str(output), fs.LocalFileSystem())
    where = "bodies" if filesystem else place.format(folder=output)
    found = run(BatchTransfer(**options, output=where, filesystem=filesystem), rows(faces))
    check_reports(found, wanted, "written")
    if place.startswith("memory"):
        memory = fsspec.filesystem("memory")
        stored = {
            path.rpartition("/")[2]: memory.cat(path) for path in memory.find("/bucket/bodies")
        }
        records = [name for name in stored if name.endswith(".jsonl")]
        assert len(records) == 1
        assert len(stored.pop(records[0]).splitlines()) == len(wanted)
        assert stored == wanted
    else:
        assert contents(output / "bodies" if filesystem else output) == wanted
    found = run(BatchTransfer(**options, output=where, filesystem=filesystem), rows(faces))
    check_reports(found, wanted, "up to date")


def test_sources_and_shared_files_in_object_storage(faces, options, wanted, output):
    memory = fsspec.filesystem("memory")
    for name in ("pair", "onto"):
        with open(options[name], "rb") as file:
            memory.pipe_file(f"/shared/{os.path.basename(options[name])}", file.read())
    memory.pipe_file("/faces/a b/000.png", (faces / "000.png").read_bytes())
    shared = {
        "pair": "memory://shared/head_to_body.uvpair",
        "onto": "memory://shared/body_base.png",
    }
    transfer = BatchTransfer(**{**options, **shared}, output=output, root="memory://faces")
    found = run(
        transfer, [{"path": "memory://faces/a b/000.png"}, {"path": "memory://faces/no.png"}]
    )
    assert [it["status"] for it in found] == ["written", "failed"]
    assert contents(output) == {"a b/000.png": wanted["000.png"]}


class Failing(fsspec.get_filesystem_class("memory")):
    """Object storage that refuses every third object, after half of it came."""

    protocol = ("memory",)
    puts = 0

    def pipe_file(self, path, value, *arguments, **named):
        Failing.puts += 1
        if Failing.puts % 3 == 0 and path.endswith(".png"):
            raise OSError(f"{path}: connection lost")
        super().pipe_file(path, value, *arguments, **named)


def test_failed_puts_are_reported_and_made_up_for(faces, options, wanted):
    some = rows(faces)[:12]
    filesystem = Failing()
    transfer = BatchTransfer(**options, output="/failing", filesystem=filesystem)
    found = run(transfer, some)
    failed = [it for it in found if it["status"] == "failed"]
    assert failed
    assert all("connection lost" in it["error"] for it in failed)
    done = {it["output"] for it in found if it["status"] == "written"}
    assert set(filesystem.glob("/failing/*.png")) == done
    written = 0
    while failed:
        found = run(BatchTransfer(**options, output="/failing", filesystem=filesystem), some)
        failed = [it for it in found if it["status"] == "failed"]
        written += [it["status"] for it in found].count("written")
    assert written == len(some) - len(done)
    for row in some:
        name = os.path.basename(row["path"])
        assert filesystem.cat(f"/failing/{name}") == wanted[name]


def test_names(faces, options, output):
    path = str(faces / "000.png")
    data = (faces / "000.png").read_bytes()

    def outputs(some, **more):
        found = run(BatchTransfer(**options, output=output, resume=None, **more), some)
        return [it["output"] and os.path.relpath(it["output"], output) for it in found]

    assert outputs([{"path": path}], format="jpg") == ["000.jpg"]
    assert outputs([{"path": path}], root=faces.parent) == [f"{faces.name}/000.png"]
    assert outputs([{"path": path}], root=output) == [None]
    assert outputs([{"path": path, "name": "a/b.webp"}]) == ["a/b.webp"]
    bad = ["../a.png", "/a.png", "a/../b.png", "a//b.png", ""]
    assert outputs([{"bytes": data, "name": name} for name in bad]) == [None] * len(bad)
    assert outputs([{}, {"path": None, "bytes": data}]) == [None, None]
    assert sorted(contents(output)) == ["000.jpg", "a/b.webp", f"{faces.name}/000.png"]
    found = run(BatchTransfer(**options, output=output), [{"bytes": data, "name": "a.txt"}])
    assert found[0]["status"] == "failed"
    assert "txt" in found[0]["error"]


def test_sources_with_one_output_are_refused(tmp_path):
    for name in ("a.png", "a.jpg", "b/a.png", ".hidden.png", "notes.txt"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_bytes(b"")
    paths, root = find([str(tmp_path)])
    assert [os.path.relpath(path, tmp_path) for path in paths] == ["a.jpg", "a.png", "b/a.png"]
    check_distinct(paths, BatchTransfer("pair", "out", root=root))
    with pytest.raises(ValueError, match=r"a.jpg and .*a.png have the same output a.png"):
        check_distinct(paths, BatchTransfer("pair", "out", root=root, format="png"))
    with pytest.raises(ValueError, match=r"same output a\.png"):
        check_distinct(paths, BatchTransfer("pair", "out"))
    with pytest.raises(FileNotFoundError):
        find([str(tmp_path / "missing")])
    with pytest.raises(ValueError, match="at least one"):
        find([])


def test_unusable_options_raise(options, output):
    with pytest.raises(FileNotFoundError, match=r"missing.png"):
        BatchTransfer(**{**options, "onto": "missing.png"}, output=output).prepare()
    with pytest.raises(ValueError, match="resume"):
        BatchTransfer(**options, output=output, resume="names")
    with pytest.raises(TypeError, match="colour"):
        BatchTransfer(**options, output=output, colour="red").prepare()


def record(name, content="1"):
    return Record(name, "a" * 64, content * 64, "b" * 64, 7)


def test_cut_and_foreign_lines_are_left_out(tmp_path):
    files = LocalFiles()
    records = Records(files, str(tmp_path), "size")
    for name in ("a.png", "b.png"):
        records.add(record(name))
    (manifest,) = tmp_path.glob(".uvgraft-manifest-*.jsonl")
    text = manifest.read_text()
    assert [json.loads(line)["output"] for line in text.splitlines()] == ["a.png", "b.png"]
    manifest.write_text("[]\n{}\n\xff\n" + text[:-9])
    for name in ("a.png", "b.png"):
        (tmp_path / name).write_bytes(b"7 bytes")
    records = Records(files, str(tmp_path), "size")
    assert records.is_up_to_date("a.png", str(tmp_path / "a.png"), "b" * 64)
    assert not records.is_up_to_date("b.png", str(tmp_path / "b.png"), "b" * 64)
    assert not records.is_up_to_date("a.png", str(tmp_path / "a.png"), "c" * 64)
    assert not records.is_up_to_date("a.png", str(tmp_path / "none.png"), "b" * 64)


def test_objects_of_records_grow_and_are_then_left(tmp_path):
    memory = fsspec.filesystem("memory")
    records = Records(RemoteFiles(memory), "/grown", "content")
    for start in range(0, SEGMENT + 100, 50):
        for index in range(start, start + 50):
            records.add(record(f"{index}.png"))
        records.flush()
        records.flush()
    sizes = [len(memory.cat(path).splitlines()) for path in sorted(memory.find("/grown"))]
    assert sizes == [SEGMENT + 4, 100]

"""What Spark runs, with a stand-in for Spark that passes batches as Spark does."""

import pickle
import re
from pathlib import Path

import pytest
from conftest import check_reports, contents

from uvgraft.batch import SPARK_SCHEMA, BatchTransfer

pytestmark = pytest.mark.cluster
pa = pytest.importorskip("pyarrow")
pq = pytest.importorskip("pyarrow.parquet")

PAGE = Path(__file__).resolve().parents[4] / "docs" / "src" / "scale.md"
# Arrow's types as Spark spells them.
SPELLED = {
    "string": "string",
    "double": "double",
    "int64": "bigint",
    "list<element: string>": "array<string>",
    "list<item: string>": "array<string>",
}


class Frame:
    """A data frame of Spark in one process: three partitions, each of several batches."""

    def __init__(self, table):
        self.table = table

    def select(self, *names):
        return Frame(self.table.select(names))

    def repartition(self, count):
        return self

    def mapInArrow(self, function, schema):  # noqa: N802 - Spark's name
        # Spark pickles the function once, and unpickles it for each partition.
        data, batches = pickle.dumps(function), []
        for start in range(0, len(self.table), 70):
            part = self.table.slice(start, 70).to_batches(max_chunksize=20)
            batches += pickle.loads(data)(iter(part))
        table = pa.Table.from_batches(batches)
        fields = (f"{field.name} {SPELLED[str(field.type)]}" for field in table.schema)
        assert ", ".join(fields) == schema
        return Frame(table)

    @property
    def write(self):
        return self

    def parquet(self, path):
        pq.write_table(self.table, path)


class Spark:
    """A session of Spark that reads Parquet."""

    @property
    def read(self):
        return self

    def parquet(self, path):
        return Frame(pq.read_table(path))


def test_partitions(faces, options, wanted, output):
    frame = Frame(pa.table({"path": [str(path) for path in sorted(faces.iterdir())]}))
    transfer = BatchTransfer(**options, output=output)
    reports = frame.mapInArrow(transfer.map_in_arrow, SPARK_SCHEMA)
    check_reports(reports.table.to_pylist(), wanted, "written")
    assert contents(output) == wanted
    reports = frame.mapInArrow(transfer.map_in_arrow, SPARK_SCHEMA)
    check_reports(reports.table.to_pylist(), wanted, "up to date")


@pytest.mark.skipif(not PAGE.is_file(), reason="the book is not beside the tests")
def test_the_recipe_in_the_book(faces, options, wanted, output):
    blocks = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(), re.MULTILINE | re.DOTALL)
    (recipe,) = (block for block in blocks if "mapInArrow" in block)
    output.parent.mkdir(exist_ok=True)
    paths = [str(path) for path in sorted(faces.iterdir())]
    pq.write_table(pa.table({"path": paths}), output.parent / "faces.parquet")
    for example, real in {
        "/shared/faces.parquet": output.parent / "faces.parquet",
        "/shared/head_to_body.uvpair": options["pair"],
        "/shared/bodies": output,
        '"/shared/body.png"': f'"{options["onto"]}", size=512, blend="feather"',
        "/shared/reports": output.parent / "reports",
    }.items():
        assert example in recipe
        recipe = recipe.replace(example, str(real))
    exec(compile(recipe, "scale.md", "exec"), {"spark": Spark()})
    check_reports(pq.read_table(output.parent / "reports").to_pylist(), wanted, "written")
    assert contents(output) == wanted

"""A driver of Daft that tests kill: daft_driver.py FACES OUTPUT PIDS OPTIONS."""

import json
import os
import sys
import time
from pathlib import Path

import uvgraft.daft
from uvgraft.batch import BatchTransfer

PIDS = sys.argv[3]


class Slow(BatchTransfer):
    """Says which process it is in, and takes its time, so that it can be killed in the middle."""

    def prepare(self):
        (Path(PIDS) / str(os.getpid())).touch()
        return super().prepare()

    def run_by_row(self, rows):
        time.sleep(0.1)
        return super().run_by_row(rows)


def main():
    faces, output, _, options = sys.argv[1:]
    uvgraft.daft.BatchTransfer = Slow
    frame = uvgraft.daft.transfer(
        faces, output=output, concurrency=2, batch_size=4, **json.loads(options)
    )
    print("\n" + json.dumps(frame.to_pylist()))


if __name__ == "__main__":
    main()

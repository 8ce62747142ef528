"""A driver of Ray that tests kill: ray_driver.py FACES OUTPUT PIDS OPTIONS."""

import json
import os
import sys
import time
from pathlib import Path

import ray

import uvgraft.ray

PIDS = Path(sys.argv[3])


class Slow(uvgraft.ray.Transfer):
    """Says which process it is in, and takes its time, so that it can be killed in the middle."""

    def __init__(self, **arguments):
        super().__init__(**arguments)
        (PIDS / str(os.getpid())).touch()

    def __call__(self, batch):
        time.sleep(0.1)
        return super().__call__(batch)


def main():
    faces, output, _, options = sys.argv[1:]
    ray.init(
        num_cpus=2,
        object_store_memory=150 << 20,
        include_dashboard=False,
        log_to_driver=False,
        runtime_env={"env_vars": {"PYTHONPATH": os.environ["PYTHONPATH"]}},
    )
    uvgraft.ray.Transfer = Slow
    dataset = uvgraft.ray.transfer(
        faces, output=output, concurrency=2, batch_size=4, memory=300 << 20, **json.loads(options)
    )
    reports = dataset.take_all()
    ray.shutdown()
    print("\n" + json.dumps(reports))


if __name__ == "__main__":
    main()

"""Reads every image, mesh and model below a folder, and prints a report by suite.

    make test-peers FOLDER=suites
    make test-peers FOLDER=suites PEERS_TESTED="--kinds images"

The folders in FOLDER are the suites. Exits with 1 if anything is wrong or failed. Nothing is kept.
"""

import argparse
import os
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from peers import kinds, report, worker


def main():
    args = arguments()
    jobs = [
        (kind, path)
        for path in sorted(args.folder.rglob("*"))
        if path.is_file()
        for kind in kinds.of(path)
        if kind in args.kinds
    ]
    if not jobs:
        sys.exit(f"{args.folder}: must contain an image, a mesh or a model")
    # Each thread waits for a process of its own.
    with ThreadPoolExecutor(args.jobs, initializer=worker.start, initargs=(args.limit,)) as pool:
        outcomes = []
        for job, outcome in zip(jobs, pool.map(worker.run, jobs), strict=True):
            outcomes.append((*job, outcome))
            if args.verbose:
                print(report.line(args.folder, *outcomes[-1]), flush=True)
    print(report.text(args.folder, outcomes))
    return 1 if report.is_bad(outcomes) else 0


def arguments():
    parser = argparse.ArgumentParser(prog="peers", description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--kinds", nargs="+", choices=kinds.KINDS, default=list(kinds.KINDS))
    parser.add_argument("--limit", type=float, default=60.0, help="seconds for each file")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes at a time")
    parser.add_argument("--verbose", action="store_true", help="print each file as it is read")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())

"""Runs a command and prints its cost as JSON: wall seconds, processor seconds and peak memory.

A separate program, because a child's peak memory is never less than that of the process it was forked
from, and one that holds texture arrays uses a lot.
"""

import json
import os
import sys
import time

command = sys.argv[1:]
start = time.perf_counter()
process = os.posix_spawnp(command[0], command, os.environ)
_, status, usage = os.wait4(process, 0)
wall = time.perf_counter() - start
if status != 0:
    sys.exit(f"failed with exit code {os.waitstatus_to_exitcode(status)}: {' '.join(command)}")
# In kilobytes on Linux, in bytes on macOS.
unit = 1 if sys.platform == "darwin" else 1024
seconds = {"wall_s": wall, "cpu_s": usage.ru_utime + usage.ru_stime}
print(json.dumps(seconds | {"peak_bytes": usage.ru_maxrss * unit}))

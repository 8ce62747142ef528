"""The command ``uvgraft``: ``python -m uvgraft`` does the same."""

import sys

from uvgraft._uvgraft import run_command


def main() -> int:
    """Run the command with the arguments of this process.

    Returns
    -------
    int
        The exit code: 0 for success, 1 for a failure during the work, 2 for bad input or usage.
    """
    return run_command(["uvgraft", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())

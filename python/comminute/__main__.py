"""``python -m comminute``: the command."""

import sys

from ._comminute import command


def main() -> int:
    """Does what the command line asks for; gives the exit code."""
    return command(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(main())

"""The program `arcsmith`, which is part of the compiled module."""

import os
import signal
import sys

from ._arcsmith import main as _main


def main() -> int:
    """Run the program with the words of the command line, and return its exit code."""
    # An interrupt ends it at once, as it ends any program.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _main([os.path.abspath(sys.argv[0]), *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())

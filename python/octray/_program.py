"""The program ``octray`` of the package."""

import signal
import sys


def main() -> None:
    """Run the program with the arguments of this process."""
    from ._octray import program

    # The program handles Ctrl-C itself.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(program(["octray", *sys.argv[1:]]))

"""The command ``detune``."""

import signal
import sys

from . import run


def main() -> int:
    # Ctrl-C ends the command as it ends any other.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return run(sys.argv[1:])


if __name__ == "__main__":
    sys.exit(main())

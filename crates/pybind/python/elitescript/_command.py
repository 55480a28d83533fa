"""The console command ``eliteserver`` of the wheel: the same program as the binary."""

import signal
import sys
from typing import NoReturn

from ._elitescript import eliteserver


def main() -> NoReturn:
    # Python's own handler would only note the signal and raise later; the program hears of it itself,
    # as the binary does.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(eliteserver(["eliteserver", *sys.argv[1:]]))

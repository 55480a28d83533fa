"""Runs every test of the port clients against the server's binary: `python3 tests/clients/run.py [names]`.

Needs nothing but Python 3.9 and a built server ($ELITESERVER, or the debug build).
"""

import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).parent))

if __name__ == "__main__":
    names = sys.argv[1:]
    loader = unittest.TestLoader()
    suite = loader.loadTestsFromNames(names) if names else loader.discover(str(pathlib.Path(__file__).parent))
    result = unittest.TextTestRunner(verbosity=1).run(suite)
    sys.exit(not result.wasSuccessful())

"""Runs the command line: `python -m teletaction`."""

import sys

from teletaction.cli import main

sys.exit(main())

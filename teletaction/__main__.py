"""`python -m teletaction` is the command line."""

import sys

from teletaction.cli import main

sys.exit(main())

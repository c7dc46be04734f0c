"""Faults done to a session, one after the other and at random for long.

The registry of studies runs `soak`, the tests run `faults`.
"""

import common  # noqa: F401 (before numpy: it keeps linear algebra to the thread that asks for it)

"""Simulated devices that speak the real bytes, and the physical world they stand in."""

import common  # noqa: F401 (before numpy: it keeps linear algebra to the thread that asks for it)

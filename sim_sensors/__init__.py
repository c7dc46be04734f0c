"""Simulate the devices at the level of their bytes, and the physical world that they measure."""

import common  # noqa: F401 (before numpy: it limits linear algebra to the calling thread)

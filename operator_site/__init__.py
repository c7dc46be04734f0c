"""Runs the operator site, which renders at five fingertips what the remote fingers touch."""

import common  # noqa: F401 (before numpy: it limits linear algebra to the calling thread)

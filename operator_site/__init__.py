"""The operator site: makes five fingertips feel what the remote fingers touch."""

import common  # noqa: F401 (before numpy: it keeps linear algebra to the thread that asks for it)

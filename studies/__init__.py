"""Studies: each measures the system under controlled conditions and plots the measurements."""

import common  # noqa: F401 (before numpy: it keeps linear algebra to the thread that asks for it)

"""Studies: in each folder, `run` measures the system under controlled conditions, and `figure` draws."""

import common  # noqa: F401 (before numpy: it keeps linear algebra to the thread that asks for it)

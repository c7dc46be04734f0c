"""The remote site: reads what the telemanipulator's fingers touch and identifies it."""

import common  # noqa: F401 (before numpy: it keeps linear algebra to the thread that asks for it)

"""What the system does under conditions that are set on purpose: each study measures, and draws what it measured."""

import common  # noqa: F401 (before numpy: it keeps linear algebra to the thread that asks for it)

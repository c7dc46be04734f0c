"""Names the field that a decoder refused in a list."""

import re
from collections.abc import Sequence

_PLACE = re.compile(r"`\$\[(\d+)\]")


def misfit(names: Sequence[str], error: str) -> str:
    """Return why a decoder refused a list: the first field that does not fit, or the number of fields."""
    found = _PLACE.search(error)
    if found is None:
        return f"not a list of {len(names)} fields: {error}"
    return f"field {names[int(found[1])]}: {error}"

"""Names the field of a list that a decoder refused."""

import re
from collections.abc import Sequence

_PLACE = re.compile(r"`\$\[(\d+)\]")


def misfit(names: Sequence[str], error: str) -> str:
    """Why a list is refused: the first field that does not fit, or the number of fields.

    Args:
        names: of the list's fields, in order.
        error: of the decoder, which names the place by its number.
    """
    found = _PLACE.search(error)
    if found is None:
        return f"not a list of {len(names)} fields: {error}"
    return f"field {names[int(found[1])]}: {error}"

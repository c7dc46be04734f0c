"""A session whose remote site is in the test's hands."""

import pytest

from tests.unit.operator_site.session_pair import Pair


@pytest.fixture
def pair() -> Pair:
    """Connected."""
    made = Pair()
    made.connect()
    return made

"""A process with as many open files as under a flood of connections."""

import os
import resource
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

LARGEST_OF_SELECT = 1023
"""Largest descriptor that `select.select` takes."""


@contextmanager
def many_open_files() -> Iterator[None]:
    """Each file that is opened meanwhile has a descriptor above LARGEST_OF_SELECT."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = 2 * (LARGEST_OF_SELECT + 1)
    if hard not in (resource.RLIM_INFINITY, max(hard, wanted)):
        pytest.skip(f"this process may open {hard} files only")
    resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, wanted), hard))
    taken = [os.open(os.devnull, os.O_RDONLY)]
    try:
        while taken[-1] < LARGEST_OF_SELECT:
            taken.append(os.dup(taken[0]))
        yield
    finally:
        for descriptor in taken:
            os.close(descriptor)
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))

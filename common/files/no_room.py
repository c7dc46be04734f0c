"""Errors of a file for which there is no room."""

import errno

NO_ROOM = (errno.ENOSPC, errno.EDQUOT)
"""The disk is full, or the owner's share of it is."""

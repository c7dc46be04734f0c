"""Lets the library that opens devices find the system's configuration of ALSA."""

import os

FOLDER = "/usr/share/alsa"
"""Folder of the system's configuration; the library's own path is that of the machine on which it was built."""


def use_system_alsa() -> None:
    """Name the system's configuration, unless the environment names another; call it before a device is opened."""
    os.environ.setdefault("ALSA_CONFIG_DIR", FOLDER)

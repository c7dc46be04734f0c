"""The kinesthetic loop at 1 kHz through python-can."""

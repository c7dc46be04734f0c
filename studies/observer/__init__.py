"""Both experiments of Kron & Schmidt 2003, repeated with an observer model."""

"""Three figures of Kron & Schmidt 2003, computed on the simulated devices."""

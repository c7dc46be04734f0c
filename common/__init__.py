"""What both sites must agree on; first of all, that a loop never waits for another thread's share of its arithmetic."""

import os

# Read when numpy is loaded, hence here. On a busy machine a skin of 5 to 28 cells is solved thirty times as fast by one
# thread as by two that wait for each other: decision 31. Who sets it otherwise is left alone.
for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

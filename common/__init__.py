"""What both sites must agree on; first of all, that a loop never waits for another thread's share of its arithmetic."""

import os

# Read when numpy is loaded, hence here. Shared out among threads, a skin of 14 cells takes a hundred times as long on a
# busy machine, and now and then a tick of 100 ms: decision 31. Who sets it otherwise is left alone.
for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

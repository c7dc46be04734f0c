"""Code that both sites share. Importing it limits numerical libraries to one thread."""

import os

# The libraries read these variables when numpy is loaded, hence here. On a busy machine one thread solves a skin of
# 5 to 28 cells thirty times as fast as two threads that wait for each other (decision 31). A value that the user has
# set stays.
for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

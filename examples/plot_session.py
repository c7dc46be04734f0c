"""Plots what the index finger touched: temperature of the object and contact force.

`python examples/plot_session.py SESSION.mcap` takes a recording. Without one, it simulates a session.
"""

import sys

import matplotlib.pyplot as plt

import teletaction as tt

session = tt.Recording(sys.argv[1]) if sys.argv[1:] else tt.simulate("materials", seconds=20.0)
index = session.touch["index"].to_pandas()
print(index[index["material"] != ""].groupby("material")[["probability", "object_c", "object_c_sd"]].median())
index[["object_c", "contact_force_n"]].plot(subplots=True, xlabel="time", ylabel="C, N")
plt.savefig("session.png")

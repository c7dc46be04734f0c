"""Identifies the material of touches.

`python examples/identify_touch.py TABLE.json TOUCH.csv ...` takes files. Without them, it simulates three touches.
"""

import sys

import teletaction as tt

table = tt.MaterialTable.load(sys.argv[1]) if sys.argv[1:] else None
touches = [tt.read_thermal(path) for path in sys.argv[2:]]
for touch in touches or [tt.simulate_thermal(name) for name in ("aluminium", "pvc", "pine")]:
    for answer in tt.identify_thermal(touch, table, at_s=(0.5, 1.0, 2.0)):
        print(f"{touch.name}: {answer['t_s']:.1f} s: {answer['status']}, likeliest {answer['best']}")

"""Soft tissue with nodules: force of a probe at a depth, from finite elements that are solved off line.

`contrast` looks the solved table up, and `ground` gives the force. `make_contrast` solves it again.
"""

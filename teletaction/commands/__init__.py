"""The commands, a file for each group of them.

They import what they need when they run: a site's process must not carry the weight of the others.
"""

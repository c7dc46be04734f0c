"""Recordings in MCAP: a process that writes, and readers of whole and cut files.

Sites use `recorder`. Tools use `reader`, and `truncated_mcap` where a file is damaged.
"""

"""Recordings in MCAP: a writer process, and readers of whole and truncated files.

Sites use `recorder`. Tools use `reader`, and `truncated_mcap` where a file is damaged.
"""

"""The commands; each file holds one group.

A command imports its modules when it runs, so that a site's process does not load those of other commands.
"""

"""A virtual environment in place of a remote site.

The command line uses `virtual_site`.
"""

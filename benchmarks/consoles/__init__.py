"""The cost of consoles and their pages.

The registry of studies runs `consoles`.
"""

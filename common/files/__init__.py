"""Reading and writing of small files, and printable text.

Each module stands alone.
"""

"""The Python interface: `import teletaction as tt`. Its names are those that `teletaction/__init__.py` lists."""

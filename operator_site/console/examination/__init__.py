"""An examination, its findings, its report and its journal on the disk.

The console uses `examination` and `journal`.
"""

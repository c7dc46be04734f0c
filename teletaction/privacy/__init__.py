"""Encrypts and decrypts files for a person, and deletes what the project has written about an examination.

Commands use `encrypt` and `forget`.
"""

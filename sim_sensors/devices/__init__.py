"""Simulated devices on serial lines and CAN.

The two processes of simulated devices use them.
"""

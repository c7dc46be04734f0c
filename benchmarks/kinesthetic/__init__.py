"""The kinesthetic loop at 1 kHz through python-can.

The registry of studies runs `kinesthetic_loop`.
"""

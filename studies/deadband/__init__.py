"""The perceptual deadband of packets.

The registry runs `deadband`.
"""

"""Receives the pictures of the remote site's camera and names a picture that is late or frozen.

The console relays and records the pictures as the camera's process has encoded them.
"""

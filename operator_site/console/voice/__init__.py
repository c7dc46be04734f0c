"""The voice between the pages and the remote site. Nothing here decodes a sound.

The console's process uses `voice`, its pages `voice_sound` and `voice_now`.
"""

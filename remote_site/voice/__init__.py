"""The remote site's voice, in a process of its own with a lower priority than touch.

The data's way: `sound_source` -> `opus_codec` -> `stream_server`, and back `jitter_buffer` -> `opus_codec` ->
`sound_sink`. Others use `voice.run_voice`.
"""

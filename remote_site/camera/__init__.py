"""The remote site's camera, in a process of its own with a lower priority than touch.

The data's way: `video_source` -> `video_encoder` -> `stream_server`, paced by `picture_readers` and `picture_ladder`.
Others use `camera.run_camera`.
"""

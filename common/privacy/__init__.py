"""Opens recordings, encrypted ones with the secret key of their recipient, and creates encrypted ones.

All tools that read recordings open them through `recording_file`.
"""

"""Records at 500 Hz until it is killed; tells through a file how far it came, once the writer has come to work."""

import mmap
import sys
import time
from pathlib import Path

from common.recording.recorder import Recorder

recording, progress, payload = Path(sys.argv[1]), Path(sys.argv[2]), bytes(int(sys.argv[3]))
progress_file = progress.open("r+b")
told = mmap.mmap(progress_file.fileno(), 8)
recorder = Recorder(recording, {"touch": {"type": "array"}, "event": {"type": "object"}}, {"key": "x"}, {"t": b"table"})
due_s = time.monotonic()
at_work = False
while True:
    now_ns = time.monotonic_ns()
    recorder.write("touch", now_ns, payload)
    at_work = at_work or bool(recorder.written)
    if at_work:
        told[:] = now_ns.to_bytes(8, "little")
    due_s += 0.002
    time.sleep(max(0.0, due_s - time.monotonic()))

"""Records at 500 Hz until it is killed; once the writer works, reports its progress through a file."""

import mmap
import sys
import time
from pathlib import Path

from common.recording.recorder import Recorder

recording, progress_path, payload = Path(sys.argv[1]), Path(sys.argv[2]), bytes(int(sys.argv[3]))
progress_file = progress_path.open("r+b")
progress = mmap.mmap(progress_file.fileno(), 8)
recorder = Recorder(recording, {"touch": {"type": "array"}, "event": {"type": "object"}}, {"key": "x"}, {"t": b"table"})
due_s = time.monotonic()
at_work = False
while True:
    now_ns = time.monotonic_ns()
    recorder.write("touch", now_ns, payload)
    at_work = at_work or bool(recorder.written)
    if at_work:
        progress[:] = now_ns.to_bytes(8, "little")
    due_s += 0.002
    time.sleep(max(0.0, due_s - time.monotonic()))

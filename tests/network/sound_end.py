"""The console's end of the voice under test: talks and listens, until its input ends.

    sound_end.py ADDRESS BASE_PORT KEYS REMOTE_PUBLIC_KEY

Prints a line at the first sound, and at the end for how long sounds came after it, s, and the age
of each of them when it arrived, s.
"""

import json
import select
import sys
import time
from contextlib import closing
from pathlib import Path

from common.link.keys import load_keys
from common.wire.voice_messages import FRAME_S, VoiceState
from operator_site.console.stream_socket import StreamSocket
from operator_site.console.voice.voice import Talk, Voice
from operator_site.console.voice.voice_sound import VoiceSound
from tests.voice_sounds import coded_tone

_STEP_S = 0.008
"""Interval between two steps, as the console's, s."""
_TALKS = Talk(VoiceState.TALKS, "test", hears=True)


def main(address: str, base_port: int, keys: Path, remote_public_key: str) -> None:
    """Talk and listen until the input ends."""
    ages_s: list[float] = []
    begun_s = time.monotonic()
    coded, number, due_s = coded_tone(1000.0, 50), 0, time.monotonic()
    line = StreamSocket("voice", address, base_port, load_keys(keys), remote_public_key)
    with closing(Voice(line)) as voice:
        while not select.select([sys.stdin], [], [], _STEP_S)[0]:
            while (now_s := time.monotonic()) >= due_s:
                due_s = max(due_s + FRAME_S, now_s - 0.1)
                number += 1
                voice.say(VoiceSound("to_remote", number, now_s - FRAME_S, 0.0, coded[number % len(coded)]))
            for sound in voice.step(1, _TALKS):
                ages_s.append(time.monotonic() - sound.captured_s)
                if len(ages_s) == 1:
                    begun_s = time.monotonic()
                    print("first sound", flush=True)
    print(json.dumps([time.monotonic() - begun_s, *ages_s[1:]]), flush=True)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), Path(sys.argv[3]), sys.argv[4])

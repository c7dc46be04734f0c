"""Makes still pictures in a process of its own with a low priority, so that the console's loop never waits for one."""

import multiprocessing
import os
import signal
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess

from operator_site.console.camera.camera_picture import Picture
from operator_site.console.camera.still_picture import PictureDecoder, jpeg_of

LONGEST_S = 10.0
"""Longest time that the process may take for a still picture, s; its start takes most of it."""
_NICE = 10
_MADE, _FAILED = b"\1", b"\0"
"""First byte of an answer: a JPEG file follows, or the reason why there is none."""
_LARGEST = 1 << 24
"""Largest answer of the process, bytes."""


class StillProcess:
    """The process. It starts with the first picture, and again with the next one after a failure."""

    def __init__(self) -> None:
        # The thread waits for the process: a full pipe would hold up the console's loop.
        self._thread = ThreadPoolExecutor(1, "stills")
        self._process: SpawnProcess | None = None
        self._pipe: Connection | None = None

    def make(self, pictures: list[Picture]) -> "Future[Picture]":
        """Decode pictures that follow those of the call before, or begin with a key picture.

        Returns:
            the last picture, with a JPEG file as its content; the result raises ValueError, OSError or EOFError where
            it could not be made, and the next call must begin with a key picture.
        """
        return self._thread.submit(self._make, pictures)

    def _make(self, pictures: list[Picture]) -> Picture:
        try:
            pipe = self._pipe or self._start()
            pipe.send(pictures)
            if not pipe.poll(LONGEST_S):
                raise TimeoutError(f"no still picture within {LONGEST_S:.0f} s")
            # Bytes and no pickled object: the process reads what a camera sends.
            made = pipe.recv_bytes(_LARGEST)
        except (OSError, EOFError):
            self._end()
            raise
        if made[:1] != _MADE:
            raise ValueError(made[1:].decode("utf-8", "replace"))
        return replace(pictures[-1], is_key=True, content=made[1:])

    def _start(self) -> Connection:
        context = multiprocessing.get_context("spawn")
        self._pipe, given = context.Pipe()
        process = context.Process(target=_run, args=(given,), name="stills", daemon=True)
        process.start()
        self._process = process
        given.close()
        return self._pipe

    def _end(self) -> None:
        if self._pipe is not None:
            self._pipe.close()
        if self._process is not None:
            self._process.kill()
            self._process.join()
        self._pipe = self._process = None

    def close(self) -> None:
        """End the process."""
        process = self._process
        if process is not None:
            process.kill()  # ends a wait for it, too
        self._thread.shutdown(cancel_futures=True)
        self._end()


def _run(pipe: Connection) -> None:
    """Answer each list of pictures with a JPEG file, or with the reason why there is none."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the console takes it and ends this process
    os.nice(_NICE)
    decoder: PictureDecoder | None = None
    with suppress(OSError, EOFError):  # the console has gone
        while True:
            pictures = pipe.recv()
            try:
                decoder = decoder or PictureDecoder()
                made = _MADE + jpeg_of(decoder.decode(pictures))
            except Exception as error:  # the library's errors have no common base
                made = _FAILED + f"{type(error).__name__}: {error}".encode()
            pipe.send_bytes(made)

"""Feeds frames to a decoder and keeps what must not grow: errors of other kinds, time for one frame, memory."""

import gc
import heapq
import statistics
import struct
import sys
from array import array
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import _lru_cache_wrapper
from time import perf_counter_ns
from typing import TypeVar

import numpy as np
import pytest

from tests.robustness.hardening.own_memory import own_resident_bytes

T = TypeVar("T")
FRAMES = [5_000, pytest.param(1_000_000, marks=[pytest.mark.hardening, pytest.mark.timeout(600)])]
"""How many go into each decoder: in every run of the tests, and when asked for."""
_SLOWEST = 20


class NotSurvived(AssertionError):
    """A frame that did what no frame may do; the message holds its bytes."""


@dataclass(frozen=True, slots=True)
class Survival:
    """What a decoder made of many broken frames."""

    frames: int
    accepted: int
    good_ns: float
    """Median time of decoding a good frame."""
    median_ratio: float
    """Median time of a broken frame over that of a good one."""
    slowest_ratio: float
    """The slowest single measurement, with whatever else the machine was doing."""
    slowest_again_ratio: float
    """The slowest of the 20 slowest frames when each is decoded again, best of five: what is the frame's own doing."""
    blocks_grown: int
    """Python's allocated memory blocks after a tenth of the frames: growth in the half of the rest where it was less.

    What frames leave behind grows in both halves, what the interpreter lays up once in one of them."""
    own_grown_bytes: int
    """Likewise the process's own resident memory; 0 where the system does not report it."""

    def __str__(self) -> str:
        return (
            f"{self.frames} frames, {self.accepted} accepted; a good one takes {self.good_ns / 1e3:.1f} us, "
            f"a broken one {self.median_ratio:.2f} times that at the median, {self.slowest_ratio:.0f} times at worst "
            f"({self.slowest_again_ratio:.1f} when decoded again); memory {self.blocks_grown:+d} blocks, "
            f"{self.own_grown_bytes / 1024:+.0f} KiB"
        )


def survive(
    decode: Callable[[bytes], T],
    declared: tuple[type[Exception], ...],
    judge: Callable[[bytes, T], None],
    good: Sequence[bytes],
    frames: Iterable[bytes],
    count: int,
) -> Survival:
    """Decode `count` frames one by one.

    Args:
        decode: the decoder.
        declared: the only errors that it may raise.
        judge: looks at what was accepted; raises AssertionError when it is not what it must be.
        good: frames that it takes, in this order, again and again.
        frames: the broken ones.
        count: how many these are.

    Raises:
        NotSurvived: another error, or something accepted that is not harmless.
    """
    good_ns = statistics.median(_time_ns(decode, frame) for frame in list(good) * (1 + 2000 // len(good)))
    took_ns = array("Q", bytes(8 * count))
    slowest: list[tuple[int, bytes]] = []
    accepted, looks = 0, {count // 10, count * 55 // 100}
    memory: list[tuple[int, int]] = []
    for number, frame in enumerate(frames):
        if number in looks:
            memory.append(_memory())
        start_ns = perf_counter_ns()
        try:
            value = decode(frame)
        except declared:
            took_ns[number] = duration_ns = perf_counter_ns() - start_ns
        except Exception as error:
            raise NotSurvived(f"frame {number} {frame.hex()}: {type(error).__name__}: {error}") from error
        else:
            took_ns[number] = duration_ns = perf_counter_ns() - start_ns
            accepted += 1
            try:
                judge(frame, value)
            except Exception as error:
                raise NotSurvived(f"frame {number} {frame.hex()} gave {value}: {error}") from error
        if len(slowest) < _SLOWEST:
            heapq.heappush(slowest, (duration_ns, frame))
        elif duration_ns > slowest[0][0]:
            heapq.heapreplace(slowest, (duration_ns, frame))
    memory.append(_memory())
    blocks_grown, own_grown_bytes = np.diff(memory, axis=0).min(axis=0).tolist()
    return Survival(
        frames=count,
        accepted=accepted,
        good_ns=good_ns,
        median_ratio=float(np.median(np.frombuffer(took_ns, dtype=np.uint64))) / good_ns,
        slowest_ratio=max(slowest)[0] / good_ns,
        slowest_again_ratio=max(min(_time_ns(decode, f, declared) for _ in range(5)) for _, f in slowest) / good_ns,
        blocks_grown=blocks_grown,
        own_grown_bytes=own_grown_bytes,
    )


def check(survival: Survival) -> None:
    """What every decoder has to keep; the numbers are printed."""
    print(survival)
    assert 0 < survival.accepted < survival.frames, "one side of the decoder was never reached"
    assert survival.median_ratio < 8.0, survival
    assert survival.blocks_grown < 100, survival
    assert survival.own_grown_bytes < 4 * 2**20, survival


def _time_ns(decode: Callable[[bytes], object], frame: bytes, declared: tuple[type[Exception], ...] = ()) -> int:
    start_ns = perf_counter_ns()
    with suppress(*declared):
        decode(frame)
    return perf_counter_ns() - start_ns


def _memory() -> tuple[int, int]:
    """Allocated blocks and own resident bytes, without what caches of bounded size remember: they fill up, and end."""
    decoders = [module for name, module in sys.modules.items() if name.startswith("common.")]
    for kept in [value for module in decoders for value in vars(module).values()]:
        if isinstance(kept, _lru_cache_wrapper) and kept.cache_info().maxsize is not None:
            kept.cache_clear()
    vars(struct)["_clearcache"]()  # of the last hundred layouts
    gc.collect()
    return sys.getallocatedblocks(), own_resident_bytes()

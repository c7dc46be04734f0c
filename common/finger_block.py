"""The block of a packet: some numbers of each finger, packed little-endian float32, each within its column's range."""

from collections.abc import Mapping, Sequence
from struct import Struct

import numpy as np

from common.fingers import FINGERS
from common.packets import BadPacket, Floats, N

_FLOAT32 = np.dtype("<f4")
_MOST_KNOWN = 256


class FingerBlock:
    """Columns of a block (5, columns) of floats.

    Attributes:
        names: of the columns, in order.
        low, high: what each column may hold, float32 (columns,).
    """

    def __init__(self, ranges: Mapping[str, tuple[float, float]], codes: Sequence[str] = ()):
        """Take each column's range; those in `codes` stand for words and hold whole numbers."""
        self.names = tuple(ranges)
        self.low: Floats = np.array([low for low, _ in ranges.values()], dtype=_FLOAT32)
        self.high: Floats = np.array([high for _, high in ranges.values()], dtype=_FLOAT32)
        self._lowest, self._highest = np.tile(self.low, (N, 1)), np.tile(self.high, (N, 1))
        self._known_codes: set[tuple[float, ...]] = set()
        self._code_names = ", ".join(codes)
        self._codes = Struct("<" + N * "".join("f" if name in codes else "4x" for name in self.names))

    def to_bytes(self, block: Floats) -> bytes:
        """Bytes of a block; raises BadPacket where a value is not what its column may hold."""
        if block.shape != self._lowest.shape or block.dtype != _FLOAT32:
            raise BadPacket(f"block: expected float32 {self._lowest.shape}, not {block.dtype} {block.shape}")
        raw = block.tobytes()
        self.from_bytes(raw)
        return raw

    def from_bytes(self, raw: object) -> Floats:
        """Array (5, columns) that cannot be written to; raises BadPacket as `to_bytes` does."""
        if type(raw) is not bytes or len(raw) != self._codes.size:
            raise BadPacket(f"block: expected {self._codes.size} bytes")
        block: Floats = np.ndarray(self._lowest.shape, _FLOAT32, raw)
        # NaN fails both comparisons, so what is not finite is out of range. Looking for a zero byte is how to ask
        # whether all are true in half the time that numpy's own question takes.
        if 0 in (block >= self._lowest).tobytes() or 0 in (block <= self._highest).tobytes():
            finger, column = np.argwhere(~((block >= self.low) & (block <= self.high)))[0]
            raise BadPacket(
                f"{FINGERS[finger]}.{self.names[column]}: {block[finger, column]} is outside "
                f"{self.low[column]:g}..{self.high[column]:g}"
            )
        codes = self._codes.unpack(raw)
        if codes not in self._known_codes:
            self._learn(codes)
        return block

    def _learn(self, codes: tuple[float, ...]) -> None:
        """Remember codes that are whole numbers: the same ones come again and again; raises BadPacket on others."""
        if not all(map(float.is_integer, codes)):
            raise BadPacket(f"block: {self._code_names}: not whole numbers")
        if len(self._known_codes) >= _MOST_KNOWN:
            self._known_codes.clear()
        self._known_codes.add(codes)

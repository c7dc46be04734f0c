"""The block of a packet: some numbers of each finger, packed little-endian float32, each within its column's range."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from common.fingers import FINGERS
from common.wire.packets import BadPacket, Floats, N

_FLOAT32 = np.dtype("<f4")
_SIGN = 1 << 31
_MOST_KNOWN = 256


class FingerBlock:
    """Columns of a block (5, columns) of floats.

    A block is judged as one whole number whose 32-bit digits are its floats. As bits, floats without their signs are
    ordered as their values are, infinity and NaN above all others: one subtraction from the largest block compares all
    digits. That is quicker than comparing arrays after a pause, when nothing is in the processor's caches; even making
    an array takes as long then as all of that, and is left to who reads the floats. What does not pass so is judged
    again, float by float.

    Attributes:
        names: of the columns, in order.
        low, high: what each column may hold, float32 (columns,).
    """

    def __init__(
        self,
        ranges: Mapping[str, tuple[float, float]],
        codes: Sequence[str] = (),
        agree: Callable[[Sequence[float]], bool] = lambda codes: True,
    ):
        """A block of columns.

        Args:
            ranges: of each column.
            codes: columns that stand for words and hold whole numbers.
            agree: whether the codes of one finger, in the order of the columns, may stand together.
        """
        self._agree = agree
        self.names = tuple(ranges)
        self.low: Floats = np.array([low for low, _ in ranges.values()], dtype=_FLOAT32)
        self.high: Floats = np.array([high for _, high in ranges.values()], dtype=_FLOAT32)
        self._shape = (N, len(self.names))
        self._bytes = 4 * N * len(self.names)
        # Where a column is symmetric, a float without its sign tells all; elsewhere a sign is not passed at once.
        signed = self.low == -self.high
        self._signs = self._number([_SIGN] * len(self.names))
        self._magnitudes = self._number([_SIGN - 1 if either else 2 * _SIGN - 1 for either in signed])
        self._largest = self._number([_SIGN | int(bits) for bits in self.high.view(np.uint32)])
        self._code_bits = self._number([2 * _SIGN - 1 if name in codes else 0 for name in self.names])
        self._code_columns = [column for column, name in enumerate(self.names) if name in codes]
        self._known_codes: set[int] = set()

    def _number(self, digits: Sequence[int]) -> int:
        """The whole number with these 32-bit digits for each finger, one for a column."""
        return int.from_bytes(np.tile(np.array(digits, dtype="<u4"), N).tobytes(), "little")

    def to_bytes(self, block: Floats) -> bytes:
        """Bytes of a block, whose values are not judged yet; raises BadPacket on another shape or type."""
        if block.shape != self._shape or block.dtype != _FLOAT32:
            raise BadPacket(f"block: expected float32 {self._shape}, not {block.dtype} {block.shape}")
        return block.tobytes()

    def array(self, raw: bytes) -> Floats:
        """The block (5, columns) that these bytes are; it cannot be written to."""
        return np.ndarray(self._shape, _FLOAT32, raw)

    def check(self, raw: object) -> bytes:
        """`raw`, the bytes of a block; raises BadPacket where a value is not what its column may hold."""
        if type(raw) is not bytes or len(raw) != self._bytes:
            raise BadPacket(f"block: expected {self._bytes} bytes")
        bits = int.from_bytes(raw, "little")
        floats = bits & self._magnitudes
        if floats & self._signs or (self._largest - floats) & self._signs != self._signs:
            self._judge(self.array(raw))
        if (codes := bits & self._code_bits) not in self._known_codes:
            self._learn(codes, self.array(raw))
        return raw

    def _judge(self, block: Floats) -> None:
        """Raise BadPacket where a value is out of its range; NaN fails both comparisons."""
        wrong = np.argwhere(~((block >= self.low) & (block <= self.high)))
        if len(wrong):
            finger, column = wrong[0]
            raise BadPacket(
                f"{FINGERS[finger]}.{self.names[column]}: {block[finger, column]} is outside "
                f"{self.low[column]:g}..{self.high[column]:g}"
            )

    def _learn(self, codes: int, block: Floats) -> None:
        """Remember codes that are whole numbers and agree: the same ones come again and again; raises BadPacket."""
        values = block[:, self._code_columns]
        if (values != np.round(values)).any():
            raise BadPacket(
                f"block: {', '.join(self.names[column] for column in self._code_columns)}: not whole numbers"
            )
        for finger, row in zip(FINGERS, values.tolist(), strict=True):
            if not self._agree(row):
                raise BadPacket(f"{finger}: codes {row} do not agree")
        if len(self._known_codes) >= _MOST_KNOWN:
            self._known_codes.clear()
        self._known_codes.add(codes)

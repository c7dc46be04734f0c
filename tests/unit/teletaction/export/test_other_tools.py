"""Exports as other tools read them: pandas, pyarrow and Rerun."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import teletaction as tt
from common.fingers import FINGERS
from common.wire.messages import OBJECT_UNKNOWN_SD_K
from teletaction.export.export import export
from teletaction.recordings.session_data import SessionData

pytestmark = pytest.mark.exports


@pytest.fixture(scope="module")
def truth(session: Path) -> SessionData:
    return SessionData.read(session)


def known_object_c(truth: SessionData, number: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Temperatures of the objects that a finger touched, C; NaN where one is not known."""
    known = (truth.touch["object_c_sd"][:, number] < OBJECT_UNKNOWN_SD_K) & (
        truth.touch["thermal_status"][:, number] > 0
    )
    return np.where(known, truth.touch["object_c"][:, number], np.nan)


def test_parquet_has_types_units_and_the_same_numbers(session: Path, truth: SessionData, tmp_path: Path) -> None:
    from pyarrow import parquet

    rows = export(session, "parquet", tmp_path)
    assert rows == {stream.replace("/", "-"): count for stream, count in truth.counts.items()}
    table = parquet.read_table(tmp_path / "remote-touch.parquet")
    for number, finger in enumerate(FINGERS):
        np.testing.assert_array_equal(table[f"{finger}.object_c"].to_numpy(), known_object_c(truth, number))
    assert table.schema.field("index.stiffness_n_m").metadata[b"unit"] == b"N/m"
    assert str(table.schema.field("wall_ns").type) == "timestamp[ns, tz=UTC]"
    assert table["thumb.roughness_v"].null_count == len(table)


def test_a_stream_is_a_data_frame(session: Path, truth: SessionData) -> None:
    frame = tt.Recording(session).touch["index"].to_pandas()
    np.testing.assert_array_equal(frame["contact_force_n"], truth.touch["contact_force_n"][:, 1])
    assert str(frame.index.tz) == "UTC"
    assert frame.index.is_monotonic_increasing


def scalars(chunks: list[Any]) -> dict[str, list[float]]:
    """Values of every curve, in order of time, by the path of its entity."""
    found: dict[str, list[tuple[int, float]]] = {}
    for chunk in chunks:
        batch = chunk.to_record_batch()
        named = [name for name in batch.schema.names if name.endswith("Scalars:scalars")]
        for name in named:
            times = batch.column(batch.schema.names.index("monotonic")).cast("int64").to_pylist()
            values = (value[0] for value in batch.column(batch.schema.names.index(name)).to_pylist())
            found.setdefault(str(chunk.entity_path), []).extend(zip(times, values, strict=True))
    return {path: [value for _, value in sorted(points)] for path, points in found.items()}


def test_rerun_reads_every_number(session: Path, truth: SessionData, tmp_path: Path) -> None:
    from rerun.chunk import RrdReader

    export(session, "rerun", tmp_path)
    curves = scalars(RrdReader(tmp_path / "session.rrd").stream().to_chunks())
    for number, finger in enumerate(FINGERS):
        expected = known_object_c(truth, number)
        curve = curves.get(f"/remote/touch/{finger}/object_c", [])
        np.testing.assert_array_equal(curve, expected[~np.isnan(expected)])
    np.testing.assert_array_equal(
        curves["/operator/rendered/index/motor_rpm"], truth.rendered["motor_rpm"][:, FINGERS.index("index")]
    )
    assert "/remote/touch/thumb/roughness_v" not in curves, "a number that is never known makes no curve"


def test_rerun_reads_the_mcap_for_foxglove(session: Path, truth: SessionData, tmp_path: Path) -> None:
    from rerun.chunk import McapReader

    export(session, "foxglove", tmp_path)
    rows: dict[str, int] = {}
    for chunk in McapReader(tmp_path / "session.mcap").stream().to_chunks():
        if not chunk.is_static:
            rows[str(chunk.entity_path)] = rows.get(str(chunk.entity_path), 0) + chunk.num_rows
    assert rows["/remote/touch"] >= truth.counts["remote/touch"]

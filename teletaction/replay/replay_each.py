"""Replays several recordings in parallel."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from common.runtime.parallel_map import Progress, in_order, unseen
from teletaction.replay.replay import replay


def replay_each(
    recordings: Sequence[Path], out: Path, processes: int, progress: Progress = unseen
) -> Iterator[tuple[Path, dict[str, Any]]]:
    """Yield each recording with the content of its `replay.json`, in the order given.

    Args:
        recordings: one recording, or several with different names.
        out: folder for the results; with several recordings, each gets a subfolder of its name.
        processes: number of processes that share the recordings; the results do not depend on it.
        progress: function that takes the share done, 0..1.

    Raises:
        ValueError: two recordings have the same name, or a recording cannot be replayed.
        OSError: a recording cannot be read, or `out` cannot be written. Of several recordings, the first such error
            comes after the others.
    """
    if len(recordings) == 1:
        yield recordings[0], replay(recordings[0], out, progress)
        return
    names: dict[str, Path] = {}
    for path in recordings:
        other = names.setdefault(path.stem, path)
        if other is not path:
            raise ValueError(f"{other} and {path}: two recordings named {path.stem}: replay them one after the other")
    jobs = [(path, out / name) for name, path in names.items()]
    errors: list[ValueError | OSError] = []
    for path, result in zip(recordings, in_order(_replay, jobs, processes, progress, fewest=2), strict=True):
        if isinstance(result, ValueError | OSError):
            errors.append(result)
        else:
            yield path, result
    if errors:
        raise errors[0]


def _replay(job: tuple[Path, Path]) -> dict[str, Any] | ValueError | OSError:
    recording, out = job
    try:
        return replay(recording, out)
    except (ValueError, OSError) as error:
        return error

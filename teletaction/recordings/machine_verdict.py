"""Describes whether a machine was fast enough for a session, and the consequences for the session's figures."""

from collections.abc import Mapping
from typing import Any

from common.runtime.rate_monitor import HELD, WINDOW_S

NEGLIGIBLE_S = 1.0
"""Longest time behind its rate at which a process hardly changes the session's figures, s."""
WHAT_HELD_MEANS = f"A process holds its rate while it makes {HELD:.0%} of its ticks, counted over {WINDOW_S:g} s."


def behind(summary: Mapping[str, Any]) -> str:
    """List the processes that did not hold their rates, with the time; empty if all did."""
    return ", ".join(f"{name} for {seconds:.0f} s" for name, seconds in _behind_s(summary).items())


def machine_verdict(summary: Mapping[str, Any]) -> str:
    """Return the verdict on `summary.json` as one paragraph; empty if it has no figures of the processes."""
    if not summary.get("loop"):
        return ""
    late_s = max(_behind_s(summary).values(), default=0.0)
    if late_s <= NEGLIGIBLE_S:
        late = f" but for {late_s:.1f} s" if late_s else ""
        return f"This machine was fast enough: every process held its rate{late}. The figures are those of the method."
    duration_s = summary.get("duration_s")
    # A process also counts its time before and after the session.
    of = f" of {duration_s:.0f} s" if isinstance(duration_s, int | float) and late_s <= duration_s else ""
    late = f"the rate was not held for {late_s:.0f} s{of} ({behind(summary)})"
    words = [
        f"This machine was too slow for {_session_size(summary)}: {late}.",
        "The figures are worse than those of the README.",
        *_consequences(summary),
        _advice(summary),
    ]
    return " ".join(words)


def _session_size(summary: Mapping[str, Any]) -> str:
    fingers = summary.get("fingers")
    return "this session" if fingers is None else "1 finger" if fingers == 1 else f"{fingers} fingers"


def _advice(summary: Mapping[str, Any]) -> str:
    """Return what takes less processor time: half the fingers; for one finger, an idle machine."""
    fingers = summary.get("fingers") or 2
    return f"Try --fingers {fingers // 2}." if fingers > 1 else "End other programs, or use a faster machine."


def _behind_s(summary: Mapping[str, Any]) -> dict[str, float]:
    loops: Mapping[str, Any] = summary.get("loop") or {}
    return {name: float(loop["behind_s"]) for name, loop in loops.items() if (loop or {}).get("behind_s")}


def _consequences(summary: Mapping[str, Any]) -> list[str]:
    """List in sentences what was late or missing in this session, as far as it was measured."""
    found = []
    delay_ms = ((summary.get("latency_ms") or {}).get("contact_to_motor") or {}).get("p50")
    if delay_ms is not None:
        found.append(f"From contact to motor it took {delay_ms:.1f} ms (median).")
    impulses, taps = summary.get("impulses") or {}, summary.get("taps") or {}
    if impulses.get("crossed"):
        missed, invented = impulses.get("missed", 0), impulses.get("invented", 0)
        found.append(f"Of {impulses['crossed']} grooves {missed} were missed, and {invented} were invented.")
    postponed = sum((loop or {}).get("postponed") or 0 for loop in summary["loop"].values())
    if postponed:
        found.append(f"Identification of materials waited in {postponed} late ticks, so names came later.")
    if taps.get("made"):
        found.append(f"Of {taps['made']} taps {taps.get('played', 0)} were displayed.")
    return found

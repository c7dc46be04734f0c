"""The verdict names the late process, the time and the losses, and leaves out unknown values."""

from teletaction.recordings.machine_verdict import behind, machine_verdict

LATE = {
    "duration_s": 60.1,
    "loop": {"remote": {"behind_s": 57.2}, "operator": {"behind_s": 0.0}, "sim-remote": {"behind_s": 3.0}},
    "latency_ms": {"contact_to_motor": {"p50": 18.04}},
    "impulses": {"crossed": 400, "missed": 49, "invented": 54},
    "taps": {"made": 43, "played": 39},
}


def test_a_late_session_names_the_late_process_and_its_effect() -> None:
    verdict = machine_verdict(LATE | {"fingers": 5})
    assert verdict.startswith("This machine was too slow for 5 fingers: the rate was not held for 57 s of 60 s")
    for part in (
        "(remote for 57 s, sim-remote for 3 s)",
        "18.0 ms",
        "Of 400 grooves 49 were missed, and 54 were invented.",
        "Of 43 taps 39 were displayed.",
        "The figures are worse than those of the README.",
        "Try --fingers 2.",
    ):
        assert part in verdict
    assert behind(LATE) == "remote for 57 s, sim-remote for 3 s"


def test_a_process_that_was_late_for_longer_than_the_session_has_no_share_of_it() -> None:
    assert "the rate was not held for 57 s (" in machine_verdict(LATE | {"duration_s": 11.0})


def test_a_punctual_session_is_reported_as_such() -> None:
    loop = {"remote": {"behind_s": 0.0}, "operator": {"behind_s": 0.8}, "gone": None}
    assert machine_verdict(LATE | {"loop": loop}).startswith("This machine was fast enough")


def test_one_finger_cannot_become_fewer() -> None:
    verdict = machine_verdict(LATE | {"fingers": 1})
    assert "too slow for 1 finger:" in verdict
    assert "--fingers" not in verdict


def test_unmeasured_values_are_left_out() -> None:
    assert machine_verdict({}) == ""
    bare = machine_verdict({"loop": {"remote": {"behind_s": 5.0}}})
    assert "5 s (remote for 5 s)" in bare
    assert "too slow for this session" in bare
    assert "Try --fingers 1." in bare
    assert "groove" not in bare
    assert "motor" not in bare

"""The operating curve of naming: counts of names, by rule."""

from studies.thermal_identification.answers import SHIPPED_RULE, Answered
from studies.thermal_identification.operating_curve import RULES, operating_curve


def answer(truth: str, best: str, named_s: float | None, caution: float) -> Answered:
    """Return the last answer to a touch by a rule."""
    rule = next(rule for rule in RULES if rule.caution == caution)
    status = "ambiguous" if named_s is None else "identified"
    return Answered("1 finger", truth, 6.0, best, 0.99, status, named_s=named_s, rule=rule)


def test_names_are_counted_by_rule() -> None:
    shipped = SHIPPED_RULE.caution
    known = [
        answer("pine", "pine", 0.8, 1.0),
        answer("pine", "pvc", 2.0, 1.0),
        answer("pvc", "pvc", None, 1.0),
        answer("pine", "pine", 4.0, shipped),
        answer("pine", "pvc", None, shipped),
        answer("pvc", "pvc", None, shipped),
    ]
    strangers = [answer("copper", "pine", 1.0, 1.0), answer("copper", "pine", None, shipped)]
    bold, cautious = operating_curve(known, strangers, world="B")
    assert (bold["world"], bold["caution"], bold["touches"]) == ("B", 1.0, 3)
    assert (bold["named_1_s"], bold["named_3_s"], bold["named_6_s"]) == (0.3333, 0.6667, 0.6667)
    assert (bold["named_s"], bold["wrong"], bold["strangers_named"]) == (1.4, 0.3333, 1.0)
    assert (cautious["named_3_s"], cautious["named_6_s"], cautious["named_s"]) == (0.0, 0.3333, 4.0)
    assert (cautious["wrong"], cautious["strangers"], cautious["strangers_named"]) == (0.0, 1, 0.0)


def test_without_strangers_there_is_no_share_of_them() -> None:
    (row,) = operating_curve([answer("pine", "pine", None, 1.0)])
    assert (row["named_s"], row["strangers"], row["strangers_named"]) == (None, 0, None)

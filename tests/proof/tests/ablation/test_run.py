"""What one recording answers without its rules."""

from tasks.explain.evidence import assemble
from tests.proof.ablation.run import SWITCHES, _Remembered, _remembers
from tests.proof.ablation.switch import Switch, off


def test_what_is_remembered_does_not_hide_what_is_switched_off():
    noise = next(each for each in SWITCHES if each.name == "reference's noise")
    assert _remembers(noise)
    with _Remembered().on(), off(noise):
        assert assemble.fitted_to_reference_noise(None, None, None) == set()


def test_a_rule_within_what_is_remembered_has_it_worked_out_anew():
    attribute = "evidence.reference_errors:REFERENCE_SHARE"
    assert not _remembers(Switch("REFERENCE_SHARE", "", attribute, 1.0))

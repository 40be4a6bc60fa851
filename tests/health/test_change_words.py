"""Words about what changed in a recording that was called off."""

from ema_twin_sim.health.judgement import Change, changed_words
from ema_twin_sim.health.judgement import _words as words_of
from tests.health_by_hand import healthy_by_hand


def test_small_changes_are_told_with_two_digits_and_standard_deviations_once():
    changes = [
        Change("roughness", 1.0032, "A", 1.0, 2.6),
        Change("friction", 1.57, "A", 1.0, 16.2),
        Change("lag", 0.999996, "rad", 1.0, 0.1),
    ]
    assert changed_words(changes) == (
        "effort in steady motion is 57% above the healthy; roughness of steady motion is 0.32% above the healthy "
        "(+16.2 and +2.6 standard deviations)"
    )


def test_one_feature_is_not_told_as_several_together():
    one, two = Change("friction", 1.02, "A", 1.0, 2.9), Change("roughness", 1.1, "A", 1.0, 2.5)
    (said,) = words_of((one,), True, healthy_by_hand())
    assert said == (
        "It differs from the healthy recordings, most in one feature: effort in steady motion is 2% above the healthy "
        "(+2.9 standard deviations)."
    )
    assert ", in several features together: " in words_of((one, two), True, healthy_by_hand())[0]

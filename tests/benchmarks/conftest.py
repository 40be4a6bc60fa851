"""What benchmarks share."""

import pytest


@pytest.fixture
def say(capfd):
    """Prints though pytest keeps what is printed."""

    def say(*words, **options):
        with capfd.disabled():
            print(*words, **options)

    return say

"""A number that the page quotes: measured here, shown there."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Number:
    """A measured ``value`` and the decimals that the page shows of it."""

    value: float
    decimals: int = 0

    @property
    def text(self) -> str:
        """As the page shows it, with a true minus sign."""
        return f"{self.value:.{self.decimals}f}".replace("-", "−")

    def is_shown_by(self, text: str) -> bool:
        """Whether ``text`` says this number, to one of its last digit: another processor may round the other way."""
        _, _, fraction = text.partition(".")
        off = abs(float(text.replace("−", "-")) - self.value)
        return len(fraction) == self.decimals and off <= 1.01 * 10.0**-self.decimals

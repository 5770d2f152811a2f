"""Numbers as people read them: true minus signs, a unit, and an interval where there is one."""

from __future__ import annotations

import math

from reports.statistics import Estimate

MISSING = "\N{EN DASH}"
MINUS = "\N{MINUS SIGN}"
NBSP = "\N{NO-BREAK SPACE}"


def number(value: float, digits: int = 2, *, signed: bool = False) -> str:
    """A number with a fixed count of decimals; a dash for NaN."""
    if math.isnan(value):
        return MISSING
    if math.isinf(value):
        return f"{MINUS if value < 0 else ''}\N{INFINITY}"
    text = f"{value:+.{digits}f}" if signed else f"{value:.{digits}f}"
    if float(text) == 0.0:
        text = text.lstrip("+-")
    return text.replace("-", MINUS)


def interval(value: Estimate, digits: int = 2, *, scale: float = 1.0, signed: bool = False) -> str:
    """The interval as "low … high", no-break; empty where there is none or it has no width."""
    if not value.has_interval or value.low == value.high:
        return ""
    low, high = (number(v * scale, digits, signed=signed) for v in (value.low, value.high))
    return f"{low}{NBSP}…{NBSP}{high}"


def telling_digits(value: Estimate, digits: int, scale: float = 1.0) -> int:
    """As many decimals as it takes for an interval that excludes zero not to read as one that touches it."""
    if value.excludes_zero:
        nearest = min(abs(value.low), abs(value.high)) * scale
        while digits < 6 and float(f"{nearest:.{digits}f}") == 0.0:
            digits += 1
    return digits


def listing(parts: list[str]) -> str:
    """Parts joined by commas and a last "and"."""
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"


def plural(count: int, noun: str) -> str:
    """A count with its noun: "1 run", "3 runs"."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"

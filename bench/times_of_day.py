"""Times of day as a study names them: hours of a date at a place, and the clear sky's sun and sky at each."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from datetime import UTC, date, datetime, time
from difflib import get_close_matches
from functools import cache
from typing import Annotated, Any
from zoneinfo import ZoneInfo, available_timezones

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from bench.study_parts import Part, refuse_unknown
from scenes.model import Sky, Sun
from scenes.sun_position import clear_sky

_CLOCK = re.compile(r"([01]?\d|2[0-3]):([0-5]\d)")
DAY_MIN = 24 * 60


@dataclass(frozen=True)
class Daylight:
    """Sun and sky at a time of day; the sun's azimuth is turned into the scene, its name is a layer's."""

    time: str
    sun: Sun
    sky: Sky


def _date(value: Any) -> date:
    if isinstance(value, str):
        try:
            value = date.fromisoformat(value)
        except ValueError:
            raise ValueError(f"no such date as {value!r}; write one such as 2026-06-21") from None
    if not isinstance(value, date) or isinstance(value, datetime):
        raise ValueError(f"should be a date such as 2026-06-21, not {value!r}")
    if not 1900 <= value.year <= 2100:
        raise ValueError(f"{value}: the sun's position is known well from 1900 to 2100 only")
    return value


def _zone(name: str) -> str:
    try:
        ZoneInfo(name)
    except (KeyError, ValueError, OSError):  # unknown; a path out of the database; a folder of it
        near = get_close_matches(name, available_timezones(), n=2, cutoff=0.5)
        hint = f"did you mean {' or '.join(map(repr, near))}?" if near else "try UTC or Europe/Berlin"
        raise ValueError(f"unknown time zone {name!r}: {hint}") from None
    return name


def _hours(value: Any) -> Any:
    """A list of clock times; ``{from: "06:00", to: "21:00", steps: n}`` as n of them, to the minute."""
    if isinstance(value, list | tuple):
        return [_clock(minutes(entry)) for entry in value]
    if not isinstance(value, dict):
        return value
    refuse_unknown(value, ("from", "to", "steps"))
    first, last, steps = (value.get(key) for key in ("from", "to", "steps"))
    start, end = minutes(first), minutes(last)
    if not start < end:
        raise ValueError(f"should run from an earlier to a later hour, not from {first} to {last}")
    if not isinstance(steps, int) or isinstance(steps, bool) or not 2 <= steps <= 1 + end - start:
        raise ValueError(f"steps should be a whole number from 2 on, at most one a minute, not {steps!r}")
    return [_clock(start + round(k * (end - start) / (steps - 1))) for k in range(steps)]


def minutes(value: Any) -> int:
    """Minutes since midnight of "09:30", or of 9 for nine o'clock.

    YAML 1.1 reads 12:30 without quotes as a number of base 60, here as 750: that is meant, too.

    Raises
    ------
    ValueError
        For anything else.
    """
    if isinstance(value, int) and not isinstance(value, bool):
        if 0 <= value < 24:
            return 60 * value
        if 60 <= value < DAY_MIN:
            return value
    if isinstance(value, str) and (found := _CLOCK.fullmatch(value)):
        return 60 * int(found[1]) + int(found[2])
    raise ValueError(f'no such hour as {value!r}; write one from "00:00" to "23:59"')


def _clock(minute: int) -> str:
    return f"{minute // 60:02d}:{minute % 60:02d}"


class TimesOfDay(Part):
    """Hours of one day at a place, under a clear sky (`scenes.sun_position`).

    ``latitude`` and ``longitude`` are degrees, north and east positive. ``hours`` is a list of clock times in
    ``time_zone`` (an IANA name), or ``{from: "06:00", to: "21:00", steps: 6}``. ``y_axis_bearing_deg`` is the
    compass bearing that the scene's y axis points to: 0 leaves a scene as built, with y to the north.
    """

    latitude: Annotated[float, Field(ge=-90, le=90)]
    longitude: Annotated[float, Field(ge=-180, le=180)]
    date: Annotated[date, BeforeValidator(_date)]
    hours: Annotated[tuple[str, ...], BeforeValidator(_hours)] = Field(min_length=1)
    time_zone: Annotated[str, AfterValidator(_zone)] = "UTC"
    altitude_m: float = Field(0.0, ge=-500, le=9000)
    y_axis_bearing_deg: float = Field(0.0, ge=-360, le=360)

    @model_validator(mode="after")
    def _every_hour_exists_once(self) -> TimesOfDay:
        for hour in self.hours:
            if self.hours.count(hour) > 1:
                raise ValueError(f"hours: {hour} stands twice; each may stand once")
            self.moment(hour)
        return self

    def moment(self, hour: str) -> datetime:
        """An hour with its date and zone; of two of the same name in autumn the first.

        Raises
        ------
        ValueError
            If the clock skips it, as in spring.
        """
        local = datetime.combine(self.date, time.fromisoformat(hour), ZoneInfo(self.time_zone))
        there = local.astimezone(UTC).astimezone(local.tzinfo)
        if there.replace(tzinfo=None) != local.replace(tzinfo=None):
            raise ValueError(f"hours: {self.time_zone} skips {hour} on {self.date}; choose another hour")
        return local

    def daylight(self) -> tuple[Daylight, ...]:
        """Sun and sky at each hour, in the order of ``hours``."""
        return tuple(self._daylight(hour) for hour in self.hours)

    def _daylight(self, hour: str) -> Daylight:
        sun, sky = _clear_sky(self.latitude, self.longitude, self.moment(hour), self.altitude_m)
        azimuth = (sun.azimuth_deg - self.y_axis_bearing_deg) % 360
        return Daylight(hour, replace(sun, azimuth_deg=azimuth, name=f"sun-{label(hour)}"), sky)


def label(hour: str) -> str:
    """Of an hour in names: ``t0900``."""
    return f"t{hour.replace(':', '')}"


@cache
def _clear_sky(latitude: float, longitude: float, moment: datetime, altitude_m: float) -> tuple[Sun, Sky]:
    return clear_sky(latitude, longitude, moment, altitude_m)

"""Empirical terms: readings or attitude that follow a course, each with factors of its own."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from tasks.explain.channels import EVERY
from tasks.model.term import Column, Inputs, Parameter, Term, Text
from tasks.motion.nudge import nudged
from tasks.motion.whole import Motion

UNNAMED = "unnamed"
LETTERS = "xyzxyz"

Courses = Callable[[Motion, Inputs, int], Sequence[np.ndarray]]


@dataclass(frozen=True)
class Follows(Term):
    """Readings of some channels follow one or more courses, each channel with its own factors.

    courses: of motion, inputs and the channel, each (n,); alike: the same for every channel.
    """

    channels: tuple[int, ...] = field(kw_only=True)
    courses: Courses = field(kw_only=True)
    alike: bool = field(default=False, kw_only=True)

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        first = self.courses(motion, inputs, self.channels[0])
        return tuple(
            {channel: np.nan_to_num(course)}
            for channel in self.channels
            for course in (first if self.alike else self.courses(motion, inputs, channel))
        )


@dataclass(frozen=True)
class Askew(Term):
    """The unit is turned by a small rotation vector that follows a course."""

    course: Callable[[Motion], np.ndarray] = field(kw_only=True)

    def moved(self, motion: Motion, values: np.ndarray) -> Motion:
        course = np.nan_to_num(self.course(motion))
        change = np.gradient(course, motion.t)
        for axis in range(3):
            if values[axis]:
                turned, speed = values[axis] * course, values[axis] * change
                motion = nudged(motion, np.eye(3)[axis], turned, speed, motion.rate)
        return motion


def follows(
    key: str,
    title: Text,
    channels: tuple[int, ...],
    number: int,
    courses: Courses,
    alike: bool = False,
) -> Follows:
    """An empirical term with `number` courses in each channel."""
    parameters = tuple(
        Parameter(
            f"{'gyro' if c < 3 else 'accel'}_{LETTERS[c]}" + (f"_{k + 1}" if number > 1 else ""),
            key, "rad/s" if c < 3 else "m/s2", 1.0, (-1.0, 1.0),
        )
        for c in channels for k in range(number)
    )  # fmt: skip
    return Follows(
        UNNAMED, "unnamed", "sensor", f"reading += c·{key}", "empirical", parameters,
        title=title, channels=channels, courses=courses, alike=alike,
    )  # fmt: skip


@dataclass(frozen=True)
class Wave(Follows):
    """Something that comes and goes with a period; shapes: the period."""

    def columns(self, motion: Motion, inputs: Inputs) -> tuple[Column, ...]:
        turned = 2.0 * np.pi * motion.t / self.at[0]
        pair = (np.sin(turned), np.cos(turned))
        return tuple({channel: course} for channel in self.channels for course in pair)

    def shaped(self, at: tuple[float, ...]) -> "Wave":
        """The wave of another period."""
        said = f"{at[0]:.3g} s"
        title = (f"a wave with a period of about {said}", f"周期约 {said} 的波动")
        return replace(self, at=at, title=title)


def wave(channels: tuple[int, ...], period: float = 100.0) -> Wave:
    """A wave in some channels, at any phase in each."""
    plain = follows("a wave", ("", ""), channels, 2, lambda motion, inputs, channel: ())
    shape = Parameter("period", "P", "s", 1.0, (0.5, 2000.0))
    return Wave(
        plain.name, plain.family, plain.stage, "reading += a·sin(2πt/P) + b·cos(2πt/P)",
        plain.source, plain.parameters, (shape,), (period,),
        channels=channels, courses=plain.courses,
    ).shaped((period,))  # fmt: skip


def slow_course(said: Term | None, waves: int) -> Follows:
    """Slow waves of half a period and more over the run, in every channel.

    said: the term whose name and texts it takes; without one it is `unnamed`.
    """

    def courses(motion: Motion, inputs: Inputs, channel: int) -> list[np.ndarray]:
        share = (motion.t - motion.t[0]) / (motion.t[-1] - motion.t[0])
        return [np.cos(np.pi * k * share) for k in range(1, waves + 1)]

    title = ("a slow drift that nothing recorded follows", "与任何记录量均无关的缓慢漂移")
    drift = follows("slow waves", title, EVERY, waves, courses, True)
    if said is None:
        return drift
    texts = ("name", "family", "equation", "source", "title", "confused_with", "separated_by")
    return replace(drift, **{text: getattr(said, text) for text in texts})

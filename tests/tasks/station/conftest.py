"""A sink that keeps everything, and a procedure that is over in half a minute of the station."""

from dataclasses import dataclass, field

import pytest

from schemas.procedure import Procedure
from schemas.recording import Manifest, Stream, joined
from tasks.station import procedures


@dataclass
class Kept:
    """Streams in the pieces they came in, and every manifest."""

    pieces: dict[str, list[Stream]] = field(default_factory=dict)
    manifests: list[Manifest] = field(default_factory=list)

    def append(self, name: str, stream: Stream) -> None:
        self.pieces.setdefault(name, []).append(stream)

    def manifest(self, manifest: Manifest) -> None:
        self.manifests.append(manifest)

    def stream(self, name: str) -> Stream:
        return joined(self.pieces[name])

    def measured(self) -> list[str]:
        """Names of the measured segments in the last manifest."""
        segments = self.manifests[-1].segments or ()
        return [s.name for s in segments if s.kind in ("static", "rate")]


@pytest.fixture(scope="session")
def new_sink() -> type[Kept]:
    return Kept


@pytest.fixture
def kept() -> Kept:
    return Kept()


@pytest.fixture(scope="session")
def short() -> Procedure:
    """Two positions and two rates of JJF 2003, 2 s each."""
    values = procedures.load("jjf2003").model_dump()
    first, third, run = (values["steps"][place] | {"dwell_s": 2.0} for place in (0, 2, 13))
    run["rates_deg_s"] = (-50, 100)
    values |= {"steps": (first, third, run), "warm_up_s": 1.0}
    return Procedure.model_validate(values)

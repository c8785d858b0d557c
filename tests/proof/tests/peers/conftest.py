"""Two short runs of the plant as the peers see them: one clean, one with an even scale factor."""

import pytest

from schemas.recording import Recording
from tests.proof.peers.observation import Observation, see
from tests.proof.plant.case import Case, EffectCall
from tests.proof.plant.simulate import Simulated, simulate

SHORT = Case(seed=77, rates_deg_s=(50.0, 100.0, 200.0), dwell_s=8.0, rate_hz=50, grade="tactical")
BENT = (EffectCall(name="gyro_scale_nonlinearity", strength=3.0,
                   parameters={"order": 2, "coefficient": [2e-3, 2e-3, 2e-3]}),)  # fmt: skip


@pytest.fixture(scope="session")
def clean() -> Recording:
    return simulate(SHORT).recording


@pytest.fixture(scope="session")
def bent() -> Simulated:
    """A gyro whose scale factor grows with the rate."""
    return simulate(SHORT.model_copy(update={"effects": BENT}))


@pytest.fixture(scope="session")
def observation_clean(clean: Recording) -> Observation:
    return see(clean)


@pytest.fixture(scope="session")
def observation_bent(bent: Simulated) -> Observation:
    return see(bent.recording)

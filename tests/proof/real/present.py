"""Effects that are really present in the real recordings, and doubtful claims, all by hand."""

from tests.proof.real.claims import claims_of
from tests.proof.real.fact import Claim, Fact, Recordings
from tests.proof.real.on_rate_table import on_rate_table
from tests.proof.real.on_shaft import on_shaft
from tests.proof.real.two_positions import two_positions

RECORDINGS = (
    "ln100_two_position", "adi_mems_two_position", "encoder_mpu6050_pitch_slow",
    "ferraris_session", "vn200_57630_six_position", "vn200_imu0_rate_table",
    "vn200_imu1_rate_table",
)  # fmt: skip
# xsens_multiposition tells no motion: explain refuses it, rightly.


def facts_of(recordings: Recordings) -> list[Fact]:
    """Everything known of the recordings, by hand alone."""
    return [*two_positions(recordings), *on_shaft(recordings), *on_rate_table(recordings)]


def doubtful(recordings: Recordings) -> list[Claim]:
    """Claims that explain makes, or made, and what the hand says of them."""
    return claims_of(recordings)

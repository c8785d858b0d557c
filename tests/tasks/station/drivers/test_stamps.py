import numpy as np

from schemas.unit_link import UnitLink
from tasks.station.drivers.samples import no_samples, sample_type
from tasks.station.drivers.unit import StampSequence
from tests.tasks.station.sample_stations import rates_link, sample

LINK = rates_link()
NARROW = LINK.model_dump(mode="json")
NARROW["frame"]["fields"][1] = {"name": "time", "type": "uint32", "unit": "us"}
UNTIMED = UnitLink.model_validate(sample("text_table")["unit_link"])


def samples(*stamps_us: int, link: UnitLink = LINK) -> np.ndarray:
    made = np.zeros(len(stamps_us), sample_type(link.frame))
    made["stamp"] = stamps_us
    return made


def fed(sequence: StampSequence, *stamps_us: int) -> list[int]:
    return sequence.take(samples(*stamps_us), 0.0)["stamp"].tolist()


def test_a_false_frame_among_good_ones_is_dropped_and_counted():
    sequence = StampSequence(LINK)
    assert fed(sequence, 0, 10_000, 7_000_000_000, 20_000, 3, 30_000) == [
        0, 10_000, 20_000, 30_000,
    ]  # fmt: skip
    assert sequence.rejected == 2


def test_a_last_frame_out_of_order_waits_for_the_next_to_tell():
    sequence = StampSequence(LINK)
    assert fed(sequence, 0, 10_000, 999_000_000) == [0, 10_000]
    assert fed(sequence, 20_000, 30_000) == [20_000, 30_000]
    assert sequence.rejected == 1


def test_a_silence_and_a_restart_are_told_by_two_frames():
    sequence = StampSequence(LINK)
    fed(sequence, 0, 10_000)
    assert fed(sequence, 60_000_000) == []
    assert fed(sequence, 60_010_000) == [60_000_000, 60_010_000]
    assert fed(sequence, 0, 10_000) == [0, 10_000]
    assert sequence.rejected == 0


def test_stamps_of_32_bits_run_on_past_their_turnover():
    sequence = StampSequence(UnitLink.model_validate(NARROW))
    end = 2**32
    assert fed(sequence, end - 20_000, end - 10_000, 0) == [end - 20_000, end - 10_000, end]
    assert fed(sequence, 10_000) == [end + 10_000]


def test_samples_without_time_or_counter_are_stamped_as_they_arrive():
    sequence = StampSequence(UNTIMED)
    first = sequence.take(samples(*[-1] * 3, link=UNTIMED), 100.0)["stamp"]
    assert first.tolist() == [99_980_000, 99_990_000, 100_000_000]
    early = sequence.take(samples(*[-1] * 2, link=UNTIMED), 100.005)["stamp"]
    assert early.min() > 100_000_000
    assert len(sequence.take(no_samples(UNTIMED.frame), 0.0)) == 0

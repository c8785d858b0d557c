"""The registers of the virtual station without a network: the encoder ring."""


def test_the_ring_keeps_a_minute_and_starts_at_its_oldest(in_memory):
    console = in_memory("spike@1000")

    def block(first: int) -> tuple[int, int]:
        console.write("capture_from", first)
        return int(console.read("capture_first")), int(console.read("capture_count"))

    console.wait(65.0)
    newest = int(console.read("station_time")) // 10_000
    assert block(newest - 6000) == (newest - 6000, 19)
    console.wait(25.0)
    newest = int(console.read("station_time")) // 10_000
    oldest, count = block(0)
    assert 0 < oldest <= newest - 6000
    assert count == 19

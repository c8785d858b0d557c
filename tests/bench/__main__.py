"""`make bench`: every measurement, with its limit measured in the same run."""

from tests.bench import bench_calibrate, bench_frames, bench_mcap

bench_calibrate.main()
bench_mcap.main()
bench_frames.main()

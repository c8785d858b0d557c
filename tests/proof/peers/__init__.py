"""What an engineer would use today in place of `explain`, on the same recordings: four methods.

`answer` runs blind and holds no code of the plant; `score`, `table` and `page` hold what it wrote
against the truth.

Each peer has one number, its threshold, that was set on 250 clean recordings, drawn as the trial
draws its own but from seeds that no trial has (`tests/proof/tune.py`): the 99 %
quantile of its statistic, so that about one clean recording in a hundred alarms. Those quantiles
were 3.69 standard deviations (residual threshold), 1.51 ln n (stepwise), 2.87 nats (SINDy) and
3.55 (Gaussian process, which 60 further ones put at more). Nothing else was fitted to recordings
of the plant.
"""

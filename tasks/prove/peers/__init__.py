"""What an engineer would use today in place of `explain`, on the same recordings: four methods.

`answer` runs blind and holds no code of the plant; `score`, `table` and `page` hold what it wrote
against the truth.
"""

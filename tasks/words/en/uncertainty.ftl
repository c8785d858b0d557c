## Input quantities of the uncertainty budgets.

uncertainty-repeatability = repeatability
uncertainty-drift-in-run = drift of zero and gain in the run
uncertainty-resolution = resolution
uncertainty-turned-angle = { $limit } (of a turn)
uncertainty-creep = { $limit } (while held)
uncertainty-zero-offset = zero offset
uncertainty-example-table = rate and position table
uncertainty-example-acquisition = data acquisition
uncertainty-example-repeatability = repeatability (summed)
uncertainty-gravity = local gravity
uncertainty-latitude = latitude
uncertainty-rate = table rate over whole turns
uncertainty-encoder-time = time of the polled encoders
uncertainty-commanded-rate = rate held, against the rate commanded
uncertainty-ripple = table rate within a turn
uncertainty-position = angular positioning
uncertainty-angle-repeatability = repeatability of angle
uncertainty-axes = squareness of axes
uncertainty-mounting = base of the unit in the fixture
uncertainty-time-base = time base of the recording
uncertainty-heading = heading
uncertainty-level = vertical of the outermost axis
uncertainty-fixture = squareness of fixture
uncertainty-rate-fast = table rate from 10 °/s
uncertainty-rate-medium = table rate 1 to 10 °/s
uncertainty-rate-slow = table rate below 1 °/s
uncertainty-table-angle = table angle
uncertainty-horizontal-earth = horizontal part of Earth's rotation (beyond whole turns)

## The evidence of a result.

evidence-coverage = U = k·u; k = { $k } ({ $probability } %), or, where a value of the item has fewer than { $dof } effective degrees of freedom, the largest factor of Student's t of the item's values for { $probability } %, rounded up to two decimals

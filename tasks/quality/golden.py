"""Golden units as the check of a station: what it reads of them today against its own history."""

import numpy as np

from tasks.quality.charts import Chart, individuals

# Values that make a station's limits for a golden unit: sigma by moving ranges of 20 is known to
# 17 %, and more would include the drift of years. Later values are judged, and shift no limit.
HISTORY = 20
# Fewer give no limits: of 8 values sigma is known to 30 % only.
FEWEST = 8


def station_check(values: np.ndarray) -> Chart | None:
    """The chart of the values (n,) of a golden unit on a station, in the order of time.

    None where there are fewer than FEWEST.
    """
    return individuals(values, HISTORY) if len(values) >= FEWEST else None

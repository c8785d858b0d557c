"""Effects that are events in the readings and no term of a model: found by looking at samples."""

from collections.abc import Mapping

from tasks.model.effect import Effect

_EVENTS = (
    Effect(
        "gyro_saturation", "gyro", "event", "ω′ᵢ = max(−L, min(L, ω′ᵢ))",
        "IEEE Std 528; IEEE Std 1431", confused_with=("gyro_scale_nonlinearity",),
    ),
    Effect(
        "accel_saturation", "accelerometer", "event", "a′ᵢ = max(−L, min(L, a′ᵢ))",
        "IEEE Std 528; IEEE Std 1293", confused_with=("accel_nonlinearity",),
    ),
    Effect(
        "dropped_samples", "time", "event", "y′ₖ = y(tₖ + n·Δt) after n lost samples",
        "definition of a time stamp; IEEE Std 1554", confused_with=("clock_skew", "time_offset"),
    ),
    Effect(
        "coarse_quantisation", "electronics", "event",
        "y′ᵢ = q·round(yᵢ/q), white noise q²/12 where the noise is large", "IEEE Std 1241",
        confused_with=("bias_random_walk",),
    ),
    Effect(
        "mains_pickup", "electronics", "event",
        "bᵢ(t) = Aᵢ·cos(2πf·t + φᵢ), f = |n·fs − 50 Hz| or |n·fs − 60 Hz|", "IEEE Std 952",
        confused_with=("rate_ripple",),
    ),
)  # fmt: skip

EVENTS: Mapping[str, Effect] = {event.name: event for event in _EVENTS}

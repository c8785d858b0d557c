"""Normal equations solved: the generalised inverse that every fit shares."""

import numpy as np

RANK = 1e-9  # of the largest eigenvalue of the scaled normal matrix: smaller ones are rounding


def inverse(normal: np.ndarray) -> np.ndarray:
    """Generalised inverse of a symmetric matrix (p, p), scaled to a unit diagonal first."""
    scale = np.sqrt(np.maximum(np.diag(normal), 0.0))
    scale = np.divide(1.0, scale, out=np.zeros_like(scale), where=scale > 0)
    values, vectors = np.linalg.eigh(normal * scale[:, None] * scale)
    kept = values > RANK * max(float(values[-1]), 0.0) if len(values) else np.zeros(0, bool)
    turned = vectors[:, kept]
    return np.asarray((turned / values[kept]) @ turned.T * scale[:, None] * scale)

"""Has four peers answer a recording in a process that knows nothing of the truth.

Needs the extra `peers` (`tests.proof.peers.installed` says whether it is there).
"""

import json
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from schemas.recording import Recording
from tests.proof.peers.blocks import BLOCK_RATE
from tests.proof.peers.gp_discrepancy import gp_discrepancy
from tests.proof.peers.observation import CHANNELS, Observation, see
from tests.proof.peers.peer import Answer
from tests.proof.peers.residual_threshold import residual_threshold
from tests.proof.peers.sindy import sindy
from tests.proof.peers.stepwise_bic import stepwise_bic

ANSWER, PREDICTION = "peers.json", "peers.parquet"
PEERS: Mapping[str, Callable[[Observation], Answer]] = {
    "residual_threshold": residual_threshold,
    "stepwise_bic": stepwise_bic,
    "sindy": sindy,
    "gp_discrepancy": gp_discrepancy,
}

Predictions = dict[str, np.ndarray]


def answer_peers(recording: Recording, folder: Path) -> None:
    """Writes peers.json and peers.parquet to folder/. A failure is an answer, too.

    peers.parquet: at each block `<channel>_nominal`, the standard's model as the peers fit it, and
    `<channel>_<peer>` where a peer predicts something else; float32.
    """
    folder.mkdir(parents=True, exist_ok=True)
    started = time.perf_counter()
    response: dict[str, Any] = {"format": "mimu-peers/1", "block_rate": BLOCK_RATE}
    try:
        observation = see(recording)
    except Exception as failure:
        response["failed"] = _why(failure)
        response["peers"] = {name: _failed(failure, 0.0) for name in PEERS}
    else:
        response["noise"] = {CHANNELS[c]: _block_noise(observation, c) for c in observation.used}
        response["prepared_in"] = time.perf_counter() - started
        response["peers"], predictions = _answers(observation)
        pq.write_table(pa.table(predictions), folder / PREDICTION, compression="zstd")
    response["seconds"] = time.perf_counter() - started
    (folder / ANSWER).write_text(
        json.dumps(response, indent=1, ensure_ascii=False), encoding="utf-8"
    )


def _answers(observation: Observation) -> tuple[dict[str, Any], Predictions]:
    known = np.asarray((observation.observed.weight > 0).any(axis=1))
    predictions = {
        f"{channel}_nominal": np.where(known, observation.nominal[:, c], np.nan).astype(np.float32)
        for c, channel in enumerate(CHANNELS)
    }
    response = {}
    for name, peer in PEERS.items():
        started = time.perf_counter()
        try:
            found = peer(observation)
        except Exception as failure:
            response[name] = _failed(failure, time.perf_counter() - started)
            continue
        response[name] = _response(found, time.perf_counter() - started)
        predictions |= _changed(name, found, observation, known)
    return response, predictions


def _changed(name: str, answer: Answer, observation: Observation, known: np.ndarray) -> Predictions:
    """The channels of which a peer predicts something else than the standard's model."""
    if answer.found is None:
        return {}
    return {
        f"{CHANNELS[c]}_{name}": np.where(known, answer.found[:, c], np.nan).astype(np.float32)
        for c in observation.used
        if not np.array_equal(answer.found[:, c], observation.nominal[:, c])
    }


def _response(answer: Answer, seconds: float) -> dict[str, Any]:
    return {
        "detected": answer.detected,
        "statistic": answer.statistic,
        "threshold": answer.threshold,
        "located": [
            {
                "channel": each.channel,
                "dimension": each.dimension,
                "description": each.description,
                "segments": list(each.segments),
                "strength": each.strength,
            }
            for each in answer.located
        ],
        "names": list(answer.names),
        "held_out_rms_ratio": answer.held_out.rms_ratio,
        "held_out_gain": answer.held_out.gain,
        "seconds": seconds,
        "failed": None,
    }


def _failed(failure: Exception, seconds: float) -> dict[str, Any]:
    nothing = _response(Answer(0.0, 0.0), seconds)
    return nothing | {"failed": _why(failure)}


def _why(failure: Exception) -> str:
    return f"{type(failure).__name__}: {failure}"


def _block_noise(observation: Observation, channel: int) -> float:
    """Standard deviation of one block's white noise, rad/s or m/s²."""
    return float(np.sqrt(observation.noises[channel].white * BLOCK_RATE / 2.0))

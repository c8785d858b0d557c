"""Reproduces a calibration result from its evidence file, with numpy alone, and decides again:
    python customers_script.py FILE [RULE] [LIMITS]
RULE: simple_acceptance, or guard_band (w = U); that of the file where none is named.
LIMITS: a JSON file of own limits, {"gyro_bias": {"lower": -0.1, "upper": 0.1}, ...}.
"""

import json
import sys

import numpy as np


def load(path):
    try:
        with open(path, encoding="utf-8") as file:
            return json.load(file)
    except (OSError, ValueError) as error:
        sys.exit(f"{path}: this file cannot be read as JSON ({error}); ask for it again.")


def read(path):
    document = load(path)
    found = document.get("format") if isinstance(document, dict) else None
    if found != "mimu-evidence/1":
        sys.exit(f"{path}: its format is {found!r}, not 'mimu-evidence/1'; give an evidence file.")
    return document


def reproduce(document):
    """(value, u) of every value: o·U + constant, and the root of its budget's squares."""
    channels = document["channels"]
    first = np.cumsum([0, *(len(channel["means"]) for channel in channels)])
    means = np.concatenate([channel["means"] for channel in channels])
    noise = np.zeros((len(means), len(means)))
    for start, channel in zip(first, channels, strict=False):
        for i, row in enumerate(channel["covariance"]):
            noise[start + i, start : start + i + 1] = row
    noise += np.tril(noise, -1).T

    def combination(stated):
        weights = np.zeros(len(means))
        weights[first[stated["channel"]] + stated["mean"]] = stated["weight"]
        return weights

    sources = [s for s in document["sources"] if s["draws"]]
    effects = [np.array([combination(draw) for draw in s["draws"]]) for s in sources]
    for value in document["values"]:
        variance = sum(line["contribution"] ** 2 for line in value["lines"])
        if value["combination"] is None:
            yield value["value"], np.sqrt(variance)  # as stated: not a combination of means
            continue
        o = combination(value["combination"])
        variance += value["scatter"] ** 2 * (o @ noise @ o)
        for source, effect in zip(sources, effects, strict=True):
            if value["without_earth"] or not source["latitude"]:
                variance += source["u"] ** 2 * ((effect @ o) ** 2).sum()
        yield o @ means + value["constant"], np.sqrt(variance)


def decide(value, u, U, limit, rule):
    """The verdict on one value by JCGM 106, as the laboratory's guide states its rules."""
    lower = -np.inf if limit.get("lower") is None else limit["lower"]
    upper = np.inf if limit.get("upper") is None else limit["upper"]
    own = limit.get("guard_band_factor") if limit.get("rule") == "guard_band" else None
    r = {"guard_band": 1.0 if own is None else own}.get(rule, 0.0)
    least = limit.get("min_capability") or (0.0 if rule == "shared_risk" else 1.0)
    one_sided = np.isinf(lower) or np.isinf(upper)
    decides = 0 < U <= (limit.get("U_max") or np.inf)
    if one_sided and r <= 0 and not limit.get("U_max"):
        decides = U > 0 and min(abs(value - lower), abs(value - upper)) > 1.645 * u
    elif decides:
        decides = (upper - lower) / (2 * U) >= max(least, r)
    if not decides:
        outside = value + U < lower or value - U > upper
        return "fail" if outside and U > 0 else "inconclusive"
    return "pass" if lower + r * U <= value <= upper - r * U else "fail"


def main(path, rule=None, own=None):
    document = read(path)
    decided = (document["decision"] or {"limits": []})["limits"]
    limits = {(each["item"], each["element"], each["applied_to"]): each for each in decided}
    of_item = load(own) if own else None
    print("value quantity unit value u U k stated_value stated_U verdict")
    for stated, (value, u) in zip(document["values"], reproduce(document), strict=True):
        item, element, quantity = stated["item"], stated["element"], stated["quantity"]
        limit = limits.get((item, element, quantity))
        if of_item is not None:
            limit = of_item.get(item) if quantity == "value" else None
        by = rule or (limit or {}).get("rule") or "simple_acceptance"
        U = max(stated["k"] * u, stated["capability"] or 0.0)
        verdict = decide(value, u, U, limit, by) if limit else "-"
        print(f"{item}.{element} {quantity} {stated['unit']} {value:.12g} {u:.6g} "
              f"{U:.6g} {stated['k']:g} {stated['value']:.12g} {stated['U']} "
              f"{verdict}")  # fmt: skip


if __name__ == "__main__":
    main(*sys.argv[1:])

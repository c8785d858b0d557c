"""The DCC as a customer reads it, who knows refTypes and nothing of the program's labels."""

import math
import os
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from dcc_json_toolkit import cache
from dcclib.conversion import JSONConverter
from lxml import etree

from schemas.laboratory import ErrorBound
from tasks.calibrate.calibrate import calibrate
from tasks.certificate.dcc import dcc_of
from tasks.certificate.figures import curves_of_run
from tasks.conformity import decide
from tasks.specifications.register import BY_STANDARD
from tests.tasks.certificate.sample_certificate import certificate, laboratory

SCHEMAS = Path(os.environ.get("MIMUCAL_DCC_SCHEMA", "../shared/dcc"))
NAMES = {"dcc": "https://ptb.de/dcc", "si": "https://ptb.de/si"}
IN_SI = {"1": 1.0, "m": 1.0, "m/s2": 1.0, "deg": math.pi / 180, "deg/s": math.pi / 180}
RECORDINGS = {"JJF 2003-2022": "plant_earth_rotation", "JJF 1536-2015": "ahrs_clean"}


def of_type(root: Any, ref_type: str, tag: str = "dcc:quantity") -> list[Any]:
    return list(
        root.xpath(
            f"//{tag}[contains(concat(' ', normalize-space(@refType), ' '), ' {ref_type} ')]",
            namespaces=NAMES,
        )
    )


@pytest.fixture(scope="module", params=list(RECORDINGS))
def made(request, plant) -> Any:
    recording = plant(RECORDINGS[request.param])
    result = calibrate(BY_STANDARD[request.param], recording, run="r1", code_version="test")
    curves = curves_of_run(recording, result)
    return certificate(result, decide(result, None), manifest=recording.manifest, curves=curves)


def test_an_element_is_found_by_its_ref_type_alone_with_value_and_u_in_si(made):
    root = etree.fromstring(dcc_of(made))
    gravity = made.manifest.station.gravity_m_s2
    looked_up = 0
    for name, item in made.calibration.items.items():
        factor = IN_SI.get(item.unit) or math.pi / 180 / gravity
        for element, value in item.value.items():
            (quantity,) = of_type(root, f"mimucal_{name}_{element}")
            si = quantity.xpath(".//si:real", namespaces=NAMES)[0]  # the SI unit stands first
            U = item.U[element] * factor
            assert float(si.findtext("si:value", namespaces=NAMES)) == pytest.approx(
                value * factor, abs=0.06 * U
            )
            stated = float(si.findtext(".//si:valueExpandedMU", namespaces=NAMES))
            assert U * 0.995 <= stated <= U * 1.1  # u_c has three digits before U goes up
            looked_up += 1
    assert looked_up == {"jjf2003": 42, "jjf1536": 12}[made.calibration.method]


def test_no_two_values_of_a_result_have_the_same_ref_type(made):
    root = etree.fromstring(dcc_of(made))
    own = [
        token
        for quantity in root.iter(f"{{{NAMES['dcc']}}}quantity")
        for token in str(quantity.get("refType", "")).split()
        if token.startswith("mimucal_") and quantity.find("dcc:noQuantity", NAMES) is None
    ]
    limits = {"mimucal_lower", "mimucal_upper", "mimucal_accept-lower", "mimucal_accept-upper"}
    assert [token for token, n in Counter(own).items() if n > 1 and token not in limits] == []


def test_a_curve_is_found_by_its_figure_quantity_and_axis(made):
    root = etree.fromstring(dcc_of(made))
    for curve in made.curves:
        (found,) = of_type(
            root, f"mimucal_{curve.figure}_{curve.quantity}_{curve.axis}", "dcc:list"
        )
        listed = found.xpath(".//si:valueXMLList", namespaces=NAMES)
        assert [len(each.text.split()) for each in listed] == [len(curve.x), len(curve.y)]


def test_the_limits_of_a_standard_are_numbers_with_their_units():
    table = laboratory().equipment[0].model_copy(
        update={
            "limits": {
                "rate": ErrorBound(half_width=2e-5, distribution="normal"),
                "position": ErrorBound(half_width=1.5e-5, distribution="rectangular"),
            }
        }
    )  # fmt: skip
    root = etree.fromstring(dcc_of(certificate(laboratory=laboratory(equipment=(table,)))))
    tag = "dcc:measuringEquipmentQuantity"
    (rate,) = of_type(root, "mimucal_limit_rate", tag)
    (position,) = of_type(root, "mimucal_limit_position", tag)
    assert [q.get("refType").split()[1] for q in (rate, position)] == [
        "mimucal_distribution_normal", "mimucal_distribution_rectangular",
    ]  # fmt: skip
    numbers = [
        (float(q.findtext("si:real/si:value", namespaces=NAMES)),
         q.findtext("si:real/si:unit", namespaces=NAMES))
        for q in (rate, position)
    ]  # fmt: skip
    assert numbers == [(2e-5, r"\one"), (1.5e-5, r"\radian")]


@pytest.mark.skipif(not SCHEMAS.is_dir(), reason="the DCC schemas are not here")
def test_the_converter_of_dcclib_gives_the_same_value_under_the_same_ref_type(
    tmp_path, monkeypatch
):
    """It reads the schemas of ptb.de from its cache, where ours take their place."""
    for source in SCHEMAS.resolve().iterdir():
        (tmp_path / source.name.removeprefix("v")).symlink_to(source)
    monkeypatch.setattr(cache, "CACHE_DIR_PATH", tmp_path)
    document = JSONConverter.from_str(dcc_of(certificate()).decode()).to_dict()
    (quantity,) = (q for q in quantities(document) if "mimucal_gyro_bias_x" in q["@refType"])
    si, degrees = quantity["si:hybrid"]["si:real"]
    assert si["si:value"] == pytest.approx(0.01187 * math.pi / 180, rel=1e-9)
    assert degrees["si:value"] == 0.01187
    expanded = degrees["si:measurementUncertaintyUnivariate"]["si:expandedMU"]
    assert (expanded["si:valueExpandedMU"], expanded["si:coverageFactor"]) == (0.00035, 2.0)


def quantities(node: Any) -> Iterator[dict[str, Any]]:
    """Every quantity of the converted document that has refTypes."""
    if isinstance(node, dict):
        if "@refType" in node and ("si:hybrid" in node or "si:real" in node):
            yield node
        for each in node.values():
            yield from quantities(each)
    elif isinstance(node, list):
        for each in node:
            yield from quantities(each)

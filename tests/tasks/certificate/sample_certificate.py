"""A made-up calibration of a made-up unit, as large as a certificate gets."""

from collections.abc import Iterable
from datetime import date
from typing import Any

from schemas.calibration import Calibration, EnvironmentSeen, Item
from schemas.certificate import AsFound, Certificate, Laboratory, Order, Party
from schemas.laboratory import MeasurementStandard
from schemas.recording import Manifest, Station, Unit
from schemas.text import Remark
from schemas.tolerance import Decision, Limit, Tolerance
from tasks.certificate.content import Content, in_languages
from tasks.certificate.content import content as content_of
from tasks.conformity import decide
from tasks.specifications.estimate import BY_INPUT_AXIS, MATRIX_ELEMENTS, OFF_DIAGONAL_ELEMENTS
from tasks.uncertainty.budget import Contribution, combine, observed
from tasks.uncertainty.equipment import JJF2003

AXES = ("x", "y", "z")


def item(
    unit: str,
    clause: str,
    elements: Iterable[str],
    values: Iterable[float | None],
    u: float,
    **more: Any,
) -> Item:
    value = dict(zip(elements, values, strict=True))
    known = {e: None if v is None else u for e, v in value.items()}
    doubled = {e: None if v is None else 2 * u for e, v in value.items()}
    return Item(unit=unit, clause=clause, value=value, u=known, U=doubled, **more)


def items() -> dict[str, Item]:
    g = [0.00951, -0.00213, 0.00047, 0.00118, 0.00742, -0.00305, -0.00066, 0.00191, 0.00868]
    p = [-2.31e-5, 1.994e-2, 4.12e-5, -8.7e-6, -3.002e-2, 1.46e-4]
    earth = [0.00268 if e[0] == e[1] else 0.0 for e in MATRIX_ELEMENTS]
    cross = [3.12e-4, -1.07e-4, -2.86e-4, 9.4e-5, 1.33e-4, -4.5e-5]
    return {
        "gyro_scale_factor": item(
            "1", "7.2.1", AXES, [1.000412, 0.998973, 1.000055], 6.1e-5,
            readings=("jjf2003.table_rate",)),
        "gyro_fit_offset": item("deg/s", "7.2.1.2", AXES, [0.0123, -0.0316, 0.0072], 4.4e-4),
        "gyro_bias": item(
            "deg/s", "7.2.2", AXES, [0.01187, -0.03194, 0.00705], 1.71e-4,
            readings=("jjf2003.positions", "jjf2003.input_matrix")),
        "gyro_cross_coupling": item(
            "1", "7.2.3", BY_INPUT_AXIS, cross, 6.1e-5, readings=("jjf2003.k_gzy",)),
        "gyro_g_sensitivity": item(
            "(deg/s)/g", "7.2.2", MATRIX_ELEMENTS, g, 1.24e-4,
            readings=("jjf2003.g_earth", "jjf2003.input_matrix"),
            value_without_earth_rotation=dict(
                zip(MATRIX_ELEMENTS, (v - e for v, e in zip(g, earth, strict=True)), strict=True))),
        "accel_scale_factor": item(
            "1", "7.2.4", AXES, [0.999871, 1.000218, 1.000034], 2.1e-5),
        "accel_bias": item("m/s2", "7.2.4", AXES, [0.02114, -0.01387, 0.00461], 2.05e-4),
        "accel_cross_coupling": item(
            "1", "7.2.4", BY_INPUT_AXIS, [v / 2 for v in cross], 2.1e-5,
            readings=("jjf2003.k_azx",)),
        "accel_rate_sensitivity": item(
            "m", "7.2.5", OFF_DIAGONAL_ELEMENTS, p, 1.3e-6,
            readings=("jjf2003.p_turning", "jjf2003.p_sign", "jjf2003.p_lever_arm"),
            value_model=dict(zip(OFF_DIAGONAL_ELEMENTS, (-v for v in p), strict=True))),
    }  # fmt: skip


def with_budgets(made: dict[str, Item]) -> dict[str, Item]:
    """The items with a budget of seven lines for each element, k above two."""
    tilts = (*JJF2003.angles, JJF2003.axes, JJF2003.fixture)
    sensitivities = [(JJF2003.rates[0][1], -5.2), (JJF2003.ripple, 1 / 30)]
    sensitivities += [(tilt, 0.98) for tilt in tilts]
    lines = [Contribution(limit.quantity, c) for limit, c in sensitivities if limit is not None]
    return {
        name: each.model_copy(
            update={
                "k": 2.15,
                "uncertainty_kind": "GUM",
                "budgets": {
                    e: combine(f"{name}.{e}", each.unit, v, [observed(6.1e-5, each.unit, 18.5),
                                                            *lines])
                    for e, v in each.value.items() if v is not None
                },
            }
        )
        for name, each in made.items()
    }  # fmt: skip


def calibration(**changes: Any) -> Calibration:
    given: dict[str, Any] = {
        "recording_id": "BJ-2026-1121-03",
        "run": "4f9c1a7e20b3",
        "digest": "4f9c1a7e20b3d5586b1f0c9a7e64d28135fb0e9c1d27a4863e5f90b2c7d81a46",
        "method": "jjf2003",
        "code_version": "0.1.0+4d6c767",
        "procedure": "jjf2003-full",
        "settings": {"gravity_m_s2": 9.8015, "latitude_deg": 39.9},
        "items": items(),
        "unavailable": {},
        "remarks": (
            Remark(
                code="rate_not_reached",
                en="The largest rate of the run is 300 °/s, below the range of the unit.",
                zh="本次最大角速率为 300 °/s，低于被校对象量程。",
                segments=("rate_x_+300",),
            ),
        ),
        "environment": EnvironmentSeen(
            temperature_degc=(19.62, 20.88), humidity_percent=(41.3, 47.9)
        ),
    }
    return Calibration(**(given | changes))


def tolerance(**changes: Any) -> Tolerance:
    limits = (
        Limit(item="gyro_scale_factor", unit="1", lower=0.997, upper=1.003),
        Limit(item="gyro_bias", unit="deg/s", lower=-0.05, upper=0.05),
        Limit(item="gyro_cross_coupling", unit="1", magnitude=0.001),
        Limit(item="gyro_g_sensitivity", unit="(deg/s)/g", magnitude=0.01,
              applied_to="value_without_earth_rotation"),
        Limit(item="accel_scale_factor", unit="1", lower=0.9995, upper=1.0005),
        Limit(item="accel_bias", unit="m/s2", lower=-0.03, upper=0.03),
    )  # fmt: skip
    given: dict[str, Any] = {
        "manufacturer": "北京示例惯性科技有限公司",
        "model": "MU-300",
        "document": "Q/SL 3-2026, Table 2",
        "limits": limits,
    }
    return Tolerance(**(given | changes))


def laboratory(**changes: Any) -> Laboratory:
    given: dict[str, Any] = {
        "party": Party(
            name="Example Institute of Inertial Metrology",
            name_zh="示例惯性计量测试研究所",
            address="12 Xueyuan Road, Haidian District, Beijing 100191, China",
            address_zh="北京市海淀区学院路12号（100191）",
        ),
        "equipment": (
            MeasurementStandard(
                name="Three-axis position and rate table",
                name_zh="三轴位置速率转台",
                serial="TT3-0417",
                accuracy="U(rate) = 2×10⁻⁴ (k = 2); position ±10″",
                certificate="JL-2026-01873",
                valid_until=date(2027, 3, 14),
            ),
            MeasurementStandard(
                name="Thermo-hygrometer",
                name_zh="温湿度计",
                serial="TH-2209",
                accuracy="±0.3 °C; ±3 %RH",
                certificate="JL-2026-00562",
            ),
        ),
        "checker": "王芳 Wang Fang",
        "issuer": "张伟 Zhang Wei",
        "issuer_title": "Technical director",
        "issuer_title_zh": "技术负责人",
    }
    return Laboratory(**(given | changes))


def order() -> Order:
    return Order(
        client=Party(
            name="Sample Navigation Ltd.",
            name_zh="样例导航技术有限公司",
            address="88 Keji South Road, Nanshan District, Shenzhen 518057, China",
            address_zh="深圳市南山区科技南路88号（518057）",
        ),
        received=date(2026, 11, 16),
    )


def manifest(**unit: str) -> Manifest:
    named = {
        "manufacturer": "北京示例惯性科技有限公司",
        "model": "MU-300",
        "serial": "SN-2026-00417",
    }
    return Manifest(
        format="mimu-recording/1",
        recording_id="BJ-2026-1121-03",
        standard="JJF 2003-2022",
        unit=Unit(**(named | unit)),
        station=Station(id="TT3", latitude_deg=39.9, gravity_m_s2=9.8015, heading_deg=0.0),
    )


def printed(part: Any) -> Any:
    """A part of a certificate's content in Chinese and English, as it is printed."""
    return in_languages(part, ("zh", "en"))


def content(made: Certificate) -> Content:
    return printed(content_of(made))


def certificate(
    result: Calibration | None = None, decision: Decision | None = None, **changes: Any
) -> Certificate:
    result = result or calibration()
    given: dict[str, Any] = {
        "number": "MIMU-2026-0042",
        "state": "issued",
        "calibrated_on": date(2026, 11, 19),
        "issued_on": date(2026, 11, 21),
        "due": date(2027, 11, 19),
        "laboratory": laboratory(),
        "order": order(),
        "manifest": manifest(),
        "calibration": result,
        "decision": decision or decide(result, tolerance()),
        "tolerance": tolerance(),
        "operator": "李明 Li Ming",
    }
    return Certificate(**(given | changes))


def adjusted() -> Certificate:
    """The sample, whose y gyro bias was out of tolerance as found."""
    bias = item("deg/s", "7.2.2", AXES, [0.0125, -0.2514, 0.0071], 1.71e-4)
    before = calibration(items=items() | {"gyro_bias": bias}, run="r-as-found", digest="ab" * 32)
    found = AsFound(
        calibrated_on=date(2026, 11, 17), calibration=before, decision=decide(before, tolerance())
    )
    return certificate(as_found=found)


def bare() -> Certificate:
    """Without any item, laboratory or order."""
    result = calibration(items={}, environment=EnvironmentSeen(), remarks=(), settings={})
    return certificate(result, decide(result, None), laboratory=None, order=None)

"""What `mimucal calibrate` prints for a person."""

import pytest

from flows.print_calibration import print_calibration
from schemas.calibration import Information
from tasks.calibrate.calibrate import calibrate
from tasks.specifications.jjf2003 import JJF2003


def test_information_is_a_second_table_with_its_sentences(
    ideal_run, capsys: pytest.CaptureFixture[str]
) -> None:
    shown = {
        "noise": Information(
            title="Angle random walk", title_zh="随机游走", unit="deg/sqrt(h)",
            value={"x": 0.08433}, U={"x": 0.00134}, en="From [18] rests.", zh="静止数据。",
        ),
        "floor": Information(
            title="Bias instability", title_zh="零偏不稳定性", unit="deg/h",
            value={"x": None}, en="No floor.", zh="未见最小值。",
        ),
    }  # fmt: skip
    made = calibrate(JJF2003, ideal_run(), run="r", code_version="v")
    print_calibration(made.model_copy(update={"information": shown}))
    first, second = capsys.readouterr().out.split("for information, not decided on")
    assert "Gyro scale factor" in first
    row = next(line for line in second.splitlines() if "│ Angle random walk" in line)
    assert [cell.strip() for cell in row.split("│")[2:7]] == ["x", "0.0843", "0.0014", "2", "°/√h"]
    assert "From [18] rests." in second
    assert "│ Bias instability" not in second
    assert "· Bias instability: No floor." in second

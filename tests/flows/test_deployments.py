"""What deploy/prefect.yaml orders exists and takes the parameters it is given."""

import inspect
from pathlib import Path

import pytest
import yaml

from flows import line

DEPLOYMENTS = yaml.safe_load(
    (Path(__file__).parents[2] / "deploy" / "prefect.yaml").read_text(encoding="utf-8")
)["deployments"]


@pytest.mark.parametrize("deployment", DEPLOYMENTS, ids=lambda d: d["name"])
def test_a_deployment_names_a_flow_and_its_parameters(deployment) -> None:
    path, name = deployment["entrypoint"].split(":")
    assert path == "flows/line.py"
    order = getattr(line, name)
    asked = set(inspect.signature(order.fn).parameters)
    assert set(deployment.get("parameters", {})) <= asked
    assert deployment["work_pool"]["name"] == "line"

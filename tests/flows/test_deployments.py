"""What deploy/prefect.yaml orders exists, seen from the folder that deploy/README.md names."""

import inspect
from pathlib import Path

import pytest
import yaml
from prefect.exceptions import ParameterTypeError
from prefect.flows import load_flow_from_entrypoint

ROOT = Path(__file__).parents[2]  # the checkout: deploy/README.md says “in the checkout”
ORDER = ".venv/bin/prefect --no-prompt deploy --all --prefect-file deploy/prefect.yaml"
FILE = yaml.safe_load((ROOT / "deploy" / "prefect.yaml").read_text(encoding="utf-8"))


def test_readme_gives_the_order_for_the_folder_from_which_the_entrypoints_resolve() -> None:
    text = " ".join((ROOT / "deploy" / "README.md").read_text(encoding="utf-8").split())
    assert ORDER in text
    assert "in the checkout" in text
    assert "pull" not in FILE  # then Prefect notes the folder of the order


@pytest.mark.parametrize("deployment", FILE["deployments"], ids=lambda d: d["name"])
def test_a_deployment_names_a_flow_and_its_parameters(deployment, monkeypatch) -> None:
    monkeypatch.chdir(ROOT)
    named = load_flow_from_entrypoint(deployment["entrypoint"])
    assert set(inspect.signature(named.fn).parameters) == {"order"}
    if deployment.get("parameters"):
        named.validate_parameters(deployment["parameters"])
    with pytest.raises(ParameterTypeError):
        named.validate_parameters({"order": {"nonsense": 1}})
    assert deployment["work_pool"]["name"] == "line"

"""Writes deploy/licences.md and deploy/bom.json: every package that the program is installed with.

Names and versions are those of requirements.txt, licences those that each package states; the bill
of materials is CycloneDX 1.6. `make licences`, after `make lock`.
"""

import re
import sys
from collections import Counter
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, metadata, version
from pathlib import Path

from cyclonedx.contrib.license.factories import LicenseFactory
from cyclonedx.model.bom import Bom
from cyclonedx.model.component import Component, ComponentType
from cyclonedx.output.json import JsonV1Dot6
from packageurl import PackageURL

HERE = Path(__file__).parent
PIN = re.compile(r"^([A-Za-z0-9._-]+)==(\S+)(?: ; (.+?))?(?: \\)?$")
OTHER_SYSTEM = "not installed here"  # another system or Python needs it
NOT_STATED = "not stated"
LONGEST = 60  # characters; some packages put the whole text where the name belongs


@dataclass(frozen=True)
class Package:
    """A pinned package; when: on which systems it is needed, empty for all."""

    name: str
    version: str
    when: str

    @property
    def licence(self) -> str:
        """As the package states it: by expression, by name, or by classifier."""
        try:
            stated = metadata(self.name)
        except PackageNotFoundError:
            return OTHER_SYSTEM
        classified = [
            each.rsplit(" :: ", 1)[1]
            for each in stated.get_all("Classifier") or ()
            if each.startswith("License :: ") and each != "License :: OSI Approved"
        ]
        named = (stated.get("License") or "").strip()
        short = named if named and "\n" not in named and len(named) <= LONGEST else ""
        return stated.get("License-Expression") or short or ", ".join(classified) or NOT_STATED


def packages(requirements: str) -> list[Package]:
    """The packages of a file of requirements."""
    pins = map(PIN.match, requirements.splitlines())
    return [Package(pin[1], pin[2], pin[3] or "") for pin in pins if pin]


def as_markdown(pinned: list[Package]) -> str:
    """A row for each package, and how many have which licence."""
    counts = Counter(package.licence for package in pinned)
    rows = [f"| {p.name} | {p.version} | {p.licence} | {p.when} |" for p in pinned]
    return "\n".join([
        "# Licences of what mimucal is installed with", "",
        "Made by `make licences` from `requirements.txt` and what each package states of itself;",
        "`bom.json` is the same as a CycloneDX bill of materials. mimucal itself: Apache-2.0.", "",
        "| licence | packages |", "|---|---|",
        *(f"| {name} | {count} |" for name, count in counts.most_common()), "",
        "| package | version | licence | only where |", "|---|---|---|---|", *rows, "",
    ])  # fmt: skip


def as_bom(pinned: list[Package]) -> str:
    """CycloneDX JSON. The hashes of every file of a package are in requirements.txt."""
    factory, bom = LicenseFactory(), Bom()
    own = Component(name="mimucal", version=version("mimucal"), type=ComponentType.APPLICATION)
    bom.metadata.component = own
    for package in pinned:
        known = package.licence not in (OTHER_SYSTEM, NOT_STATED)
        bom.components.add(
            Component(
                name=package.name,
                version=package.version,
                type=ComponentType.LIBRARY,
                bom_ref=f"{package.name}=={package.version}",
                purl=PackageURL("pypi", None, package.name, package.version),
                licenses=[factory.make_from_string(package.licence)] if known else [],
            )
        )
    bom.register_dependency(own, bom.components)
    return JsonV1Dot6(bom).output_as_string(indent=1)


def main() -> None:
    """Write both files."""
    pinned = packages((HERE.parent / "requirements.txt").read_text(encoding="utf-8"))
    (HERE / "licences.md").write_text(as_markdown(pinned), encoding="utf-8")
    (HERE / "bom.json").write_text(as_bom(pinned) + "\n", encoding="utf-8")
    print(f"{len(pinned)} packages", file=sys.stderr)


if __name__ == "__main__":
    main()

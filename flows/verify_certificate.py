"""`mimucal verify FILE` for a certificate: what it is, who signed it, and what is wrong with it."""

from dataclasses import asdict
from pathlib import Path

import typer
from cryptography import x509
from cryptography.hazmat.primitives.serialization import Encoding

from flows.terminal import print_json
from schemas.base import Unusable
from tasks.certificate.verify import VerifiedFile, verify_file


def run_verify_certificate(path: Path, trust: Path | None, as_json: bool) -> None:
    """Prints what was found; exits with 1 if there are faults. Does not use the store."""
    found = verify_file(path, _certificates(trust) if trust else ())
    if as_json:
        print_json(
            {
                "format": "mimu-verify/1",
                "checked": 1,
                "faults": [{"what": str(found.path), "why": why} for why in found.faults],
                "certificate": {
                    "number": found.number,
                    "state": found.state,
                    "record_sha256": found.record_sha256,
                    "signatures": [
                        asdict(each) | {"at": each.at.isoformat()} for each in found.signatures
                    ],
                },
            }
        )
    else:
        _print(found, trusted=trust is not None)
    raise typer.Exit(1 if found.faults else 0)


def _certificates(path: Path) -> list[bytes]:
    try:
        every = x509.load_pem_x509_certificates(path.read_bytes())
    except (OSError, ValueError) as error:
        raise Unusable(
            f"--trust {path} cannot be read; give a file with certificates as PEM."
        ) from error
    return [each.public_bytes(Encoding.DER) for each in every]


def _print(found: VerifiedFile, trusted: bool) -> None:
    for fault in found.faults:
        print(f"{found.path}: {fault}")
    if found.faults:
        return
    print(f"{found.path}: whole; certificate {found.number}, {found.state}")
    print(f"record sha256:{found.record_sha256}, which its QR code holds too")
    print("whether it was amended or withdrawn since, the laboratory knows")
    for each in found.signatures:
        stamped = " (time-stamped)" if each.time_stamped else ""
        print(f"signed by {each.by} at {each.at.isoformat()}{stamped}, under {each.authority}")
        print(f"  certificate of that authority: sha256:{each.authority_sha256}")
    if not found.signatures:
        print("not signed electronically: it is what mimucal makes of its record, by whomever")
    elif not trusted:
        print("whether that authority is the laboratory's is for you to know: compare, or --trust")

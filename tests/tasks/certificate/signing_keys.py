"""Keys of a made-up laboratory: an authority, and a seal under it, as PKCS#12."""

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any

from cryptography import x509
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec, rsa
from cryptography.hazmat.primitives.serialization import (
    BestAvailableEncryption,
    Encoding,
    pkcs12,
)
from cryptography.x509.oid import NameOID

NOW = datetime(2026, 11, 21, 9, 30, tzinfo=UTC)
PASSPHRASE = "of the seal"


@dataclass(frozen=True)
class Keys:
    """key: of the seal; chain: its certificate and that of the authority."""

    key: Any
    chain: tuple[x509.Certificate, ...]

    def pkcs12(self) -> bytes:
        secret = BestAvailableEncryption(PASSPHRASE.encode())
        seal, *above = self.chain
        return pkcs12.serialize_key_and_certificates(b"seal", self.key, seal, above, secret)

    def authority_pem(self) -> bytes:
        return self.chain[-1].public_bytes(Encoding.PEM)

    def authority_der(self) -> bytes:
        return self.chain[-1].public_bytes(Encoding.DER)


def keys(
    elliptic: bool = False, days: int = 365, authority: str = "Example Root", now: datetime = NOW
) -> Keys:
    """A seal under an authority, valid for so many days from the day before `now`."""
    root_key, key = _key(elliptic), _key(elliptic)
    root = _certificate(authority, authority, root_key, root_key, now, 3650, seal=False)
    seal = _certificate("Seal of the laboratory", authority, key, root_key, now, days, seal=True)
    return Keys(key, (seal, root))


def _key(elliptic: bool) -> Any:
    if elliptic:
        return ec.generate_private_key(ec.SECP256R1())
    return rsa.generate_private_key(65537, 2048)


def _certificate(
    name: str, issuer: str, key: Any, issuer_key: Any, now: datetime, days: int, seal: bool
) -> x509.Certificate:
    usage = dict.fromkeys(
        ("key_encipherment", "data_encipherment", "key_agreement", "encipher_only",
         "decipher_only"), False,
    )  # fmt: skip
    begin = now - timedelta(days=1)
    return (
        x509.CertificateBuilder()
        .subject_name(_name(name))
        .issuer_name(_name(issuer))
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(begin)
        .not_valid_after(begin + timedelta(days=days))
        .add_extension(x509.BasicConstraints(ca=not seal, path_length=None), critical=True)
        .add_extension(
            x509.KeyUsage(
                digital_signature=seal, content_commitment=seal, key_cert_sign=not seal,
                crl_sign=not seal, **usage,
            ),
            critical=True,
        )
        .add_extension(x509.SubjectKeyIdentifier.from_public_key(key.public_key()), critical=False)
        .add_extension(
            x509.AuthorityKeyIdentifier.from_issuer_public_key(issuer_key.public_key()),
            critical=False,
        )
        .sign(issuer_key, hashes.SHA256())
    )  # fmt: skip


def _name(name: str) -> x509.Name:
    return x509.Name(
        [
            x509.NameAttribute(NameOID.COUNTRY_NAME, "CN"),
            x509.NameAttribute(NameOID.COMMON_NAME, name),
        ]
    )

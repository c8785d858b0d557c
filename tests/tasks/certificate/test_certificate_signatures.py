"""Signed certificates: other programs find the signatures good, and whoever changes a byte is
found.
"""

import io
import logging
import random
import re
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import pypdf
import pypdfium2
import pytest
import zxingcpp
from pyhanko.sign.timestamps import DummyTimeStamper

from schemas.base import Unusable
from schemas.certificate import SigningSettings, Token
from tasks.certificate.pdf import CertificateFiles, faces_of
from tasks.certificate.sign import Signing, signing_of
from tasks.certificate.verify import VerifiedFile, verify_file
from tests.tasks.certificate.sample_certificate import certificate
from tests.tasks.certificate.signing_keys import NOW, PASSPHRASE, Keys, keys

SOFTHSM = next(Path("/usr").glob("lib*/**/softhsm/libsofthsm2.so"), None)
KEY_INFO = "http://www.w3.org/2000/09/xmldsig#:KeyInfo"
PROPERTIES = "http://uri.etsi.org/01903/v1.3.2#:SignedProperties"


def needs(program: str) -> pytest.MarkDecorator:
    return pytest.mark.skipif(shutil.which(program) is None, reason=f"{program} is not here")


@pytest.fixture(scope="module", params=["rsa", "elliptic"])
def seal(request) -> Keys:
    return keys(elliptic=request.param == "elliptic")


@pytest.fixture(scope="module")
def files(seal, tmp_path_factory) -> Path:
    """The three files of a signed certificate, and the certificate of the authority."""
    folder = tmp_path_factory.mktemp("signed")
    write(faces_of(certificate(), opened(seal, folder)), folder)
    (folder / "authority.pem").write_bytes(seal.authority_pem())
    return folder


@pytest.fixture(scope="module")
def sealed(tmp_path_factory) -> Path:
    """The files under an elliptic key, for what is the same under every key."""
    folder = tmp_path_factory.mktemp("sealed")
    write(faces_of(certificate(), opened(keys(elliptic=True), folder)), folder)
    return folder


@pytest.fixture(scope="module")
def unsigned(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("unsigned")
    write(faces_of(certificate(), None), folder)
    return folder


def opened(seal: Keys, folder: Path) -> Signing:
    (folder / "seal.p12").write_bytes(seal.pkcs12())
    return signing_of(SigningSettings(pkcs12="seal.p12"), folder, PASSPHRASE, NOW)


def write(faces: CertificateFiles, folder: Path) -> None:
    for name in ("pdf", "dcc", "record"):
        path = folder / ("c." + {"pdf": "pdf", "dcc": "xml", "record": "json"}[name])
        path.write_bytes(getattr(faces, name))


def run(*command: object) -> str:
    made = subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=600)
    return made.stdout + made.stderr


@needs("pdfsig")
def test_pdfsig_finds_the_signature_of_the_pdf_good_and_over_all_of_it(files):
    found = run("pdfsig", "-nocert", files / "c.pdf")
    assert "Signature is Valid" in found
    assert "Total document signed" in found
    assert "ETSI.CAdES.detached" in found
    assert "Nov 21 2026 09:30:00" in found


@needs("xmlsec1")
def test_xmlsec1_finds_the_signature_of_the_dcc_good_under_its_authority(files):
    verify = ("xmlsec1", "--verify", "--trusted-pem", files / "authority.pem",
              "--verification-time", "2026-11-22 00:00:00",
              "--id-attr:Id", KEY_INFO, "--id-attr:Id", PROPERTIES)  # fmt: skip
    assert "SignedInfo References (ok/all): 3/3" in run(*verify, files / "c.xml")
    broken = files / "broken.xml"
    broken.write_bytes((files / "c.xml").read_bytes().replace(b"Sample Nav", b"Simple Nav"))
    assert "SignedInfo References (ok/all): 3/3" not in run(*verify, broken)


@pytest.mark.parametrize("name", ["c.pdf", "c.xml", "c.json"])
def test_every_file_of_a_signed_certificate_is_whole_by_itself(files, seal, name):
    found = verify_file(files / name, [seal.authority_der()])
    assert found.faults == ()
    assert (found.number, found.state) == ("MIMU-2026-0042", "issued")
    assert {(each.by, each.at) for each in found.signatures} == {
        ("CN=Seal of the laboratory,C=CN", NOW)
    }


@pytest.mark.parametrize("name", ["c.pdf", "c.xml", "c.json"])
def test_a_certificate_that_is_to_be_signed_by_hand_is_whole_and_says_so(unsigned, name):
    found = verify_file(unsigned / name)
    assert (found.faults, found.signatures) == ((), ())
    assert "To be signed by hand" in text_of(unsigned / "c.pdf")


@pytest.mark.parametrize(("name", "bytes_"), [("c.pdf", 12), ("c.xml", 40), ("c.json", 8)])
def test_one_flipped_byte_is_found_wherever_it_is(sealed, tmp_path, name, bytes_):
    assert missed(sealed, tmp_path, name, bytes_, lambda content, n: n) == []


def test_one_flipped_byte_within_the_signatures_themselves_is_found(files, tmp_path):
    def in_xml(content: bytes, n: int) -> int:
        return content.index(b"<ds:Signature") + n % (len(content) - content.index(b"<ds:Sig") - 40)

    def in_pdf(content: bytes, n: int) -> int:
        found = re.search(rb"/ByteRange \[0 (\d+) (\d+) ", content)
        assert found is not None
        start, end = map(int, found.groups())
        return start + n % (end - start)

    assert missed(files, tmp_path, "c.xml", 40, in_xml) == []
    assert missed(files, tmp_path, "c.pdf", 40, in_pdf) == []


@pytest.mark.rehearsal
@pytest.mark.parametrize(("name", "bytes_"), [("c.pdf", 5), ("c.xml", 30), ("c.json", 5)])
def test_one_flipped_byte_is_found_without_any_signature(unsigned, tmp_path, name, bytes_):
    assert missed(unsigned, tmp_path, name, bytes_, lambda content, n: n) == []


def missed(
    files: Path, folder: Path, name: str, count: int, place: Callable[[bytes, int], int]
) -> list[int]:
    """Where one of so many flipped bytes was not found."""
    for each in ("c.pdf", "c.xml", "c.json"):
        shutil.copy(files / each, folder / each)
    content, rng, unseen = (files / name).read_bytes(), random.Random(2026), []
    for _ in range(count):
        at = place(content, rng.randrange(len(content)))
        changed = bytearray(content)
        changed[at] ^= rng.randrange(1, 256)
        (folder / name).write_bytes(changed)
        if not verify_file(folder / name).faults:
            unseen.append(at)
    return unseen


def test_what_is_added_behind_the_signature_is_found(sealed, tmp_path):
    writer = pypdf.PdfWriter(io.BytesIO((sealed / "c.pdf").read_bytes()), incremental=True)
    writer.add_metadata({"/Subject": "passed"})
    writer.write(tmp_path / "c.pdf")
    assert verify_file(tmp_path / "c.pdf").faults


def test_a_certificate_that_another_authority_signed_is_whole_but_not_trusted(sealed):
    other = keys(elliptic=True, authority="Another Root").authority_der()
    for name in ("c.pdf", "c.xml"):
        assert fault(verify_file(sealed / name, [other])).endswith("authority that you trust")


def test_results_of_the_dcc_that_are_not_those_of_its_record_are_found_under_a_good_signature(
    tmp_path,
):
    from tasks.certificate.dcc import dcc_of
    from tasks.certificate.sign import sign_xml

    changed = dcc_of(certificate()).replace(b">0.01187<", b">0.01188<")
    (tmp_path / "c.xml").write_bytes(sign_xml(changed, opened(keys(elliptic=True), tmp_path)))
    found = fault(verify_file(tmp_path / "c.xml"))
    assert found == "the results of the DCC are not those of the record within it"


def test_the_qr_code_holds_the_number_and_the_hash_of_the_record(sealed):
    found = verify_file(sealed / "c.json")
    codes = [
        code.text
        for page in pypdfium2.PdfDocument(sealed / "c.pdf")
        for code in zxingcpp.read_barcodes(page.render(scale=2).to_pil())
    ]
    assert codes == [f"MIMU-2026-0042 sha256:{found.record_sha256}"]
    assert codes[0] in text_of(sealed / "c.pdf")


def test_the_signed_pdf_still_says_that_it_is_pdf_a_3b_with_the_dcc_as_its_alternative(sealed):
    reader = pypdf.PdfReader(sealed / "c.pdf")
    root, xmp = reader.trailer["/Root"], reader.xmp_metadata
    assert (xmp.pdfaid_part, xmp.pdfaid_conformance) == ("3", "B")
    assert xmp.xmp_modify_date == reader.metadata.modification_date.replace(tzinfo=None)
    assert root["/OutputIntents"][0]["/S"] == "/GTS_PDFA1"
    (attached,) = (each.get_object() for each in root["/AF"])
    assert attached["/AFRelationship"] == "/Alternative"
    assert attached["/EF"]["/F"]["/Subtype"] == "/application/xml"
    assert attached["/EF"]["/F"].get_data() == (sealed / "c.xml").read_bytes()
    for page in reader.pages:
        for note in page.get("/Annots", ()):
            flags = note.get_object()["/F"]
            assert flags & 4  # it is printed
            assert not flags & (1 | 2 | 32)  # neither hidden nor invisible nor kept off the screen


def test_a_key_that_has_expired_or_is_not_valid_yet_is_refused(tmp_path):
    (tmp_path / "seal.p12").write_bytes(keys(elliptic=True, days=30).pkcs12())
    settings = SigningSettings(pkcs12="seal.p12")
    for at in (NOW + timedelta(days=40), NOW - timedelta(days=2)):
        with pytest.raises(Unusable, match=r"is valid from 2026-11-20 to 2026-12-20, not on 20"):
            signing_of(settings, tmp_path, PASSPHRASE, at)


@pytest.mark.parametrize("passphrase", [None, "wrong"])
def test_a_key_that_does_not_open_is_refused_in_one_sentence(tmp_path, passphrase, monkeypatch):
    logged = io.StringIO()  # logging's own stream for what nobody takes, as in the command line
    monkeypatch.setattr(logging, "lastResort", logging.StreamHandler(logged))
    monkeypatch.setattr(logging.getLogger("pyhanko"), "propagate", False)
    (tmp_path / "seal.p12").write_bytes(keys(elliptic=True).pkcs12())
    settings = SigningSettings(pkcs12="seal.p12")
    with pytest.raises(Unusable, match="MIMUCAL_SIGNING_PASSPHRASE"):
        signing_of(settings, tmp_path, passphrase, NOW)
    with pytest.raises(Unusable, match="does not exist"):
        signing_of(SigningSettings(pkcs12="no.p12"), tmp_path, passphrase, NOW)
    assert logged.getvalue() == ""


def test_a_time_stamp_is_put_into_the_pdf(tmp_path):
    seal, stamper = keys(), keys(authority="Time Root")
    signing = replace(opened(seal, tmp_path), time_stamper=dummy_stamper(stamper))
    write(faces_of(certificate(), signing), tmp_path)
    found = verify_file(tmp_path / "c.pdf", [seal.authority_der()])
    assert found.faults == ()
    assert [each.time_stamped for each in found.signatures] == [True, False]


def dummy_stamper(of: Keys) -> DummyTimeStamper:
    from asn1crypto import keys as asn1_keys
    from asn1crypto import x509 as asn1_x509
    from cryptography.hazmat.primitives.serialization import (
        Encoding,
        NoEncryption,
        PrivateFormat,
    )
    from pyhanko_certvalidator.registry import SimpleCertificateStore

    private = of.key.private_bytes(Encoding.DER, PrivateFormat.PKCS8, NoEncryption())
    certificates = [asn1_x509.Certificate.load(c.public_bytes(Encoding.DER)) for c in of.chain]
    store = SimpleCertificateStore()
    store.register_multiple(certificates)
    key = asn1_keys.PrivateKeyInfo.load(private)
    return DummyTimeStamper(certificates[0], key, certs_to_embed=store, fixed_dt=NOW)


@pytest.mark.skipif(SOFTHSM is None, reason="SoftHSM is not here")
@needs("softhsm2-util")
@needs("pkcs11-tool")
def test_a_key_in_a_token_signs_as_one_in_a_file(tmp_path, monkeypatch):
    from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat

    seal = keys()
    (tmp_path / "tokens").mkdir()
    (tmp_path / "softhsm2.conf").write_text(f"directories.tokendir = {tmp_path / 'tokens'}\n")
    monkeypatch.setenv("SOFTHSM2_CONF", str(tmp_path / "softhsm2.conf"))
    private = seal.key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
    (tmp_path / "key.pem").write_bytes(private)
    (tmp_path / "root.der").write_bytes(seal.authority_der())
    (tmp_path / "seal.der").write_bytes(seal.chain[0].public_bytes(Encoding.DER))
    run("softhsm2-util", "--init-token", "--free", "--label", "lab", "--pin", "1234",
        "--so-pin", "4321")  # fmt: skip
    run("softhsm2-util", "--import", tmp_path / "key.pem", "--token", "lab", "--label", "seal",
        "--id", "01", "--pin", "1234")  # fmt: skip
    for label, file in (("seal", "seal.der"), ("root", "root.der")):
        run("pkcs11-tool", "--module", SOFTHSM, "--token-label", "lab", "-l", "--pin", "1234",
            "--write-object", tmp_path / file, "--type", "cert", "--label", label)  # fmt: skip
    settings = SigningSettings(pkcs11=Token(module=str(SOFTHSM), token="lab", key="seal"))
    signing = signing_of(settings, tmp_path, "1234", NOW)
    write(faces_of(certificate(), signing), tmp_path)
    for name in ("c.pdf", "c.xml"):
        assert verify_file(tmp_path / name, [seal.authority_der()]).faults == ()
    with pytest.raises(Unusable, match="the PIN in MIMUCAL_SIGNING_PASSPHRASE"):
        signing_of(settings, tmp_path, "4321", NOW)


def fault(found: VerifiedFile) -> str:
    (why,) = found.faults
    return why


def text_of(pdf: Path) -> str:
    document = pypdfium2.PdfDocument(pdf)
    return " ".join("\n".join(page.get_textpage().get_text_bounded() for page in document).split())

"""Recordings in a bucket: what a folder keeps, kept elsewhere, through faults and from anywhere."""

import json
import shutil
from collections.abc import Callable

import numpy as np
import pytest

from schemas.base import Unusable
from storage import blobs, verify
from storage.blobs import Unreachable
from storage.catalogue import runs
from storage.home import Home
from tests.storage.s3_server import Store, serving
from tests.storage.small import small

pytestmark = pytest.mark.real_time


@pytest.fixture
def keys(monkeypatch) -> None:
    for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        monkeypatch.setenv(name, "of-a-test")
    monkeypatch.setenv("AWS_EC2_METADATA_DISABLED", "true")


@pytest.fixture
def use(keys, monkeypatch) -> Callable[[str], None]:
    """Has the home keep its recordings in a bucket."""
    return lambda url: monkeypatch.setenv("MIMUCAL_STORE", url)


def test_a_recording_in_a_bucket_comes_back_with_nothing_in_the_home_but_the_catalogue(fresh, use):
    store, recording = Store(), small()
    with serving(store) as url:
        use(url)
        run, is_new = runs.add(recording, fresh)
        assert is_new
        assert {path.name for path in fresh.path.iterdir()} <= {
            "catalog.sqlite", "catalog.sqlite-wal", "catalog.sqlite-shm",
        }  # fmt: skip
        back = runs.load(run, fresh)
        for name, values in recording.imu.columns.items():
            np.testing.assert_array_equal(back.imu.columns[name], values)
        assert runs.add(recording, fresh)[1] is False
        checked, faults = verify.verify(fresh)
        assert faults == []
        assert checked == 2


def test_keys_in_the_url_open_the_bucket_and_stand_in_no_name(fresh, monkeypatch):
    for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("AWS_EC2_METADATA_DISABLED", "true")
    with serving(Store()) as url:
        monkeypatch.setenv("MIMUCAL_STORE", url.replace("s3://", "s3://KEY:se/c+r@e#t@"))
        run, _ = runs.add(small(), fresh)
        assert runs.load(run, fresh).digest == run.digest
        assert "e#t" not in blobs.blobs_of(fresh).where("raw")
    monkeypatch.setenv("MIMUCAL_STORE", "s3://KEY@bucket/prefix")
    with pytest.raises(Unusable, match="cannot be used"):
        blobs.blobs_of(fresh)


def test_columns_that_went_missing_in_a_bucket_are_made_again_from_raw(fresh, use):
    store = Store()
    with serving(store) as url:
        use(url)
        run, _ = runs.add(small(), fresh)
        kept = {name for name in store.objects if not name.endswith("/")}
        for name in [name for name in kept if "/columns/" in name and "imu" in name]:
            store.objects[name] = b"damaged"
        assert runs.load(run, fresh).digest == run.digest
        assert runs.from_columns(run, fresh) is not None
        # pyarrow leaves a marker where it deleted the last file of a folder
        assert {name for name in store.objects if not name.endswith("/")} == kept


@pytest.mark.parametrize(
    "names",
    ["../../elsewhere.parquet", "/elsewhere.parquet", "sub/imu.parquet", "", "i" * 300, None],
)
def test_a_manifest_in_a_bucket_that_names_what_is_no_file_of_its_folder_is_made_again(
    fresh, use, names
):
    store = Store()
    with serving(store) as url:
        use(url)
        run, _ = runs.add(small(), fresh)
        (manifest,) = [each for each in store.objects if each.endswith("/manifest.json")]
        whole = store.objects[manifest]
        damaged = json.loads(whole) | {"streams": {"imu": names}} if names is not None else []
        store.objects[manifest] = json.dumps(damaged).encode()
        assert runs.from_columns(run, fresh) is None
        assert runs.load(run, fresh).digest == run.digest
        assert store.objects[manifest] == whole


def test_damaged_raw_in_a_bucket_is_a_fault(fresh, use):
    store = Store()
    with serving(store) as url:
        use(url)
        runs.add(small(), fresh)
        (raw,) = [name for name in store.objects if name.endswith(".mcap")]
        store.objects[raw] = store.objects[raw][:-1000]
        (fault,) = verify.verify(fresh)[1]
        assert "s3://lab/mimu/raw/" in fault.what


def test_a_bucket_that_answers_500_and_slowly_costs_time_alone(fresh, use):
    store = Store(every=4, pause_s=0.01)
    with serving(store) as url:
        use(url)
        for start in range(3):
            run, _ = runs.add(small(float(start)), fresh)
            assert runs.load(run, fresh).digest == run.digest
    assert store.faults > 3


def test_a_bucket_that_is_gone_is_a_sentence_and_no_damage(fresh, use, monkeypatch):
    monkeypatch.setattr(blobs, "ATTEMPTS", 1)
    monkeypatch.setattr(blobs, "CONNECT_S", 0.5)
    with serving(Store()) as url:
        use(url)
        run, _ = runs.add(small(), fresh)
    with pytest.raises(Unreachable, match="s3://lab/mimu/columns"):
        runs.load(run, fresh)


@pytest.mark.parametrize("url", ["http://lab/x", "s3:///x", "s3://lab/x?key=secret", "lab"])
def test_a_store_that_is_no_bucket_is_refused(fresh, use, url):
    use(url)
    with pytest.raises(Unusable, match="MIMUCAL_STORE"):
        runs.add(small(), fresh)


def test_a_folder_and_a_bucket_hold_the_same_bytes(fresh, use, tmp_path, monkeypatch):
    run, _ = runs.add(small(), fresh)
    raw = (fresh.raw / f"{run.digest}.mcap").read_bytes()
    store = Store()
    with serving(store) as url:
        use(url)
        elsewhere = Home(tmp_path / "elsewhere")
        runs.add(small(), elsewhere)
        shutil.rmtree(elsewhere.path)
    assert store.objects[f"lab/mimu/raw/{run.digest}.mcap"] == raw


def test_a_file_without_a_suffix_is_a_file_in_a_bucket_too(fresh, use):
    """As the statistics that `review` keeps of each run."""
    with serving(Store()) as url:
        use(url)
        bucket = blobs.blobs_of(fresh)
        name = "statistics/0123abcd"
        with bucket.local(name) as path:
            assert not path.exists()
        bucket.keep(name, lambda path: path.write_bytes(b"kept") and None)
        assert bucket.exists(name)
        with bucket.local(name) as path:
            assert path.read_bytes() == b"kept"

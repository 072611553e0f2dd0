"""Data frames against the files that `stiffbench export` writes."""

import json

import numpy as np
import pandas as pd
import pytest
import stiffbench


def exported(program, data, folder):
    assert program("export", data, "--out", folder)["ok"]
    package = json.loads((folder / "datapackage.json").read_text())
    return package["resources"]


def test_tables(program, demo, tmp_path):
    resources = exported(program, demo, tmp_path / "tables")
    tables = stiffbench.tables(demo)
    assert list(tables) == [resource["name"] for resource in resources]
    assert list(tables) == ["readings", "stiffness", "budget", "loads", "flags"]
    for resource in resources:
        frame = tables[resource["name"]]
        expected = pd.read_csv(tmp_path / "tables" / resource["path"], dtype=str, keep_default_na=False)
        fields = resource["schema"]["fields"]
        assert list(frame.columns) == [field["name"] for field in fields]
        assert len(frame) == len(expected)
        assert frame.attrs["title"] == resource["title"]
        for field in fields:
            column, other = frame[field["name"]], expected[field["name"]]
            if field["type"] in ("number", "integer"):
                assert [float(text or "nan") for text in other] == pytest.approx(list(column), rel=0, abs=0, nan_ok=True)
            elif field["type"] == "string":
                assert list(column) == list(other)
            assert frame.attrs["units"].get(field["name"], "") == field.get("unit", "")


def test_readings(demo):
    frame = stiffbench.readings(demo)
    assert len(frame) == 480 and frame["force_N"].dtype == float and frame["step"].dtype == int
    assert set(frame["status"]) == {"accepted"}
    # The slope of the fitted line is the stiffness that the command states, to the noise of one line.
    cell = frame[(frame["pose"] == "P1") & (frame["direction"] == "x")]
    slope = np.polyfit(cell["displacement_um"], cell["force_N"], 1)[0]
    stated = stiffbench.stiffness(demo)["data"]["cells"][0]["stiffness_regression"]["value"]
    assert slope == pytest.approx(stated, rel=0.01)


def test_arrays_without_pandas(demo, monkeypatch):
    import sys

    frame = stiffbench.readings(demo)
    monkeypatch.setitem(sys.modules, "pandas", None)
    arrays = stiffbench.readings(demo, arrays=True)
    assert list(arrays) == list(frame.columns)
    np.testing.assert_array_equal(arrays["force_N"], frame["force_N"])
    with pytest.raises(ImportError, match="arrays=True"):
        stiffbench.readings(demo)


def test_times(sprung):
    frame = stiffbench.readings(sprung)
    assert frame["t_s"].is_monotonic_increasing


def test_failure():
    with pytest.raises(stiffbench.StiffbenchError) as raised:
        stiffbench.readings("not-there")
    assert raised.value.exit_code == 11

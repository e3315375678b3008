"""A table of labelled runs holds what the study holds, with the role of every column."""

import json

import pyarrow.parquet as parquet
from support.commands import ok
from support.studies import study_file

from wrsim.results.files import STUDY
from wrsim.results.netcdf import write_netcdf
from wrsim.study.collect import collected
from wrsim.study.plan import planned
from wrsim.study.task import COMPLETED, DERAILED, Marker


def test_a_row_a_case_with_inputs_outputs_and_the_digest_of_its_scenario(tmp_path):
    plan, _ = planned(study_file(tmp_path), tmp_path / "out")
    markers = [
        Marker(case.name, case.label, COMPLETED if i else DERAILED, "", {"Y_max_kN": 10.0 + i}, {"Y_max_kN": "kN"})
        for i, case in enumerate(plan.cases)
    ]
    write_netcdf(tmp_path / "out" / STUDY, collected(plan, markers))
    assert "6 rows, 5 completed" in ok("dataset", tmp_path / "out").output
    table = parquet.read_table(tmp_path / "out" / "dataset.parquet")
    rows = table.to_pylist()
    assert [row["case"] for row in rows] == [case.name for case in plan.cases]
    assert [(row["friction"], row["speed_kmh"]) for row in rows] == [
        (case.values["contact.friction"], case.values["vehicle.speed_kmh"]) for case in plan.cases
    ]
    assert [row["Y_max_kN"] for row in rows] == [10.0 + i for i in range(6)]
    assert [row["status"] for row in rows] == [DERAILED] + [COMPLETED] * 5
    roles = {field.name: field.metadata[b"role"].decode() for field in table.schema}
    assert roles == {
        "case": "scenario digest", "status": "status", "friction": "input", "speed_kmh": "input", "Y_max_kN": "output",
    }  # fmt: skip
    assert table.schema.field("friction").metadata[b"key"] == b"contact.friction"
    assert "base.toml" in json.loads(table.schema.metadata[b"wrsim"])["study_text"]

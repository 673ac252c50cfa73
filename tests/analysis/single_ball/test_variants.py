"""Campaigns side by side."""

from millscale.analysis.single_ball.variants import main, variant_rows


def test_each_campaign_and_scheme_has_a_row_with_its_lifter_and_phase(runs, capsys):
    rows = variant_rows([runs, runs], S=2.6, policy="corrected")
    assert [row["scheme"] for row in rows] == 2 * ["constant-gravity", "constant-speed"]
    assert {row["id"] for row in rows} == {"sb-cg-corrected-S2.600", "sb-cs-corrected-S2.600"}
    assert all(9.0 < row["face_angle_deg"] < 9.6 and row["phase_deg"] == 0.0 for row in rows)
    assert main([str(runs)]) == 0
    table = capsys.readouterr().out.splitlines()
    assert len(table) == 2 + 2
    assert len({line.count("|") for line in table}) == 1
    assert "| 63.90 | 35.50 | 2.184 |" in table[2]
    assert table[2].endswith("* |")


def test_folder_without_a_campaign_is_told(tmp_path, capsys):
    assert main([str(tmp_path)]) == 1
    assert "no such file" in capsys.readouterr().err

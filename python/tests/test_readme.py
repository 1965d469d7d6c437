"""The ten lines of the README, as they stand there."""

import re
from pathlib import Path

README = Path(__file__).parent.parent / "README.md"


def test_the_ten_lines_give_a_diagnosis_with_a_picture(tmp_path, monkeypatch, capsys):
    (block,) = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    assert len([line for line in block.splitlines() if line.strip()]) <= 10
    monkeypatch.chdir(tmp_path)
    exec(compile(block, str(README), "exec"), {})
    sentence, reduction = capsys.readouterr().out.splitlines()
    assert "thermal lag" in sentence
    assert float(reduction) > 0.5
    page = (tmp_path / "diagnosis.html").read_text(encoding="utf-8")
    assert page.count("<svg") == 3
    assert "<script" not in page
    assert 'src="http' not in page

from services.doctor import Verdict, examine


def test_doctor_finds_what_the_lock_installs_and_advises_on_the_rest():
    findings = {each.name: each for each in examine()}
    assert findings["numpy"].verdict is Verdict.OK
    assert findings["numpy"].found.startswith("2.")
    assert findings["open3d imports"].verdict is Verdict.OK
    assert findings["parser: embedded"].verdict is Verdict.OK
    for each in findings.values():
        assert bool(each.todo) == (each.verdict is not Verdict.OK), each


def test_an_absent_ace_is_optional_and_says_how_to_install_it(monkeypatch):
    monkeypatch.setenv("PATH", "")
    ace = next(each for each in examine() if each.name == "parser: ace")
    assert ace.verdict is Verdict.OPTIONAL
    assert "ace-0.9.34" in ace.todo

"""Shipped files are found in a checkout and in a wheel."""

from slipctl import shipped


def test_the_checkout_s_own_folders_are_found():
    assert "magellan_pro" in shipped.model_names()
    assert {"friction-sweep", "paper-kinematic", "wet-slope", "tyre-creep", "belt"} <= set(
        shipped.scenario_names()
    )
    assert all(shipped.model_path(name).is_file() for name in shipped.model_names())
    assert all(shipped.scenario_path(name).is_file() for name in shipped.scenario_names())
    assert shipped.baseline_folder().parent == shipped.scenario_path("belt").parent


def test_names_are_sorted():
    assert list(shipped.scenario_names()) == sorted(shipped.scenario_names())


def test_folders_inside_the_package_come_first(tmp_path, monkeypatch):
    package = tmp_path / "site" / "slipctl"
    for folder in (package / "models", package / "scenarios", package.parent / "models"):
        folder.mkdir(parents=True)
    (package / "models" / "inside.xml").touch()
    (package.parent / "models" / "outside.xml").touch()
    (package / "scenarios" / "b.toml").touch()
    (package / "scenarios" / "a.toml").touch()
    (package / "scenarios" / "notes.md").touch()
    monkeypatch.setattr(shipped, "_PACKAGE", package)
    assert shipped.model_names() == ("inside",)
    assert shipped.scenario_names() == ("a", "b")
    assert shipped.baseline_folder() == package / "scenarios" / "baselines"


WITHOUT_BASELINE = {
    "burger": "its model misses three closed forms, and the gate asks for a certificate",
    "bumpy-floor": "15 s of one core, and its claims hold it",
    "slope-torque-model": "a mistake on show: the robot rolls back by metres, which test_shipped_laws holds",
    "wrong-beliefs": "6 s of one core, a table of docs/wrong-beliefs.md",
    "wrong-beliefs-inertia": "7 s of one core, a table of docs/wrong-beliefs.md",
    "wrong-beliefs-torque": "7 s of one core, a table of docs/wrong-beliefs.md",
    "wrong-beliefs-track": "6 s of one core, a table of docs/wrong-beliefs.md",
}
"""Shipped scenarios that are not gated by their numbers, and why."""


def test_every_other_shipped_scenario_has_a_baseline_and_its_tracks():
    """A bare `slipctl check` takes what it finds: a baseline that is gone would not be missed."""
    recorded = {path.stem for path in shipped.baseline_folder().glob("*.json")}
    assert recorded == set(shipped.scenario_names()) - set(WITHOUT_BASELINE)
    assert set(WITHOUT_BASELINE) < set(shipped.scenario_names())
    tracks = {path.name for path in shipped.baseline_folder().glob("*.parquet")}
    assert tracks == {f"{name}.tracks.parquet" for name in recorded}

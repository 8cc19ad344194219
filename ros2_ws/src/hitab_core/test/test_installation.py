"""The command that an error gives for installing HiTAB again fits how it was installed."""

import pytest

from hitab_core import installed_as, way_to_install
from hitab_core.library import installation


@pytest.mark.parametrize(
    ("there", "scripts", "place", "way"),
    [
        ({"hitab": "0.1.0"}, True, "installed by pip", 'pip install --upgrade "hitab[studio]"'),
        ({"hitab_core": "0.1.0"}, True, "checkout", "/scripts/setup"),
        ({"hitab_core": "0.1.0"}, False, "of a ROS 2 workspace", "workspace"),
        ({}, False, "of a ROS 2 workspace", "workspace"),
    ],
)
def test_the_way_to_install_is_that_by_which_it_was_installed(
    there, scripts, place, way, tmp_path, monkeypatch
):
    def version(name):
        if name not in there:
            raise installation.PackageNotFoundError(name)
        return there[name]

    module = tmp_path / "ros2_ws/src/hitab_core/hitab_core/library/installation.py"
    monkeypatch.setattr(installation, "version", version)
    monkeypatch.setattr(installation, "__file__", str(module))
    if scripts:
        (tmp_path / "scripts").mkdir()
        (tmp_path / "scripts/setup").touch()
    assert place in installed_as()
    assert way in way_to_install("studio")

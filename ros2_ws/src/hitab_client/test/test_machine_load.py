"""A machine that is too busy to answer in time is called so, with its load."""

import os

from hitab_client import machine_load


def test_a_machine_is_busy_if_more_wants_to_run_than_it_has_cores(monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1})
    monkeypatch.setattr(os, "getloadavg", lambda: (2.4, 9.0, 9.0))
    assert machine_load.busy() == ""
    monkeypatch.setattr(os, "getloadavg", lambda: (6.04, 0.0, 0.0))
    assert machine_load.busy() == "this machine is busy (load 6.0 on 2 cores)"

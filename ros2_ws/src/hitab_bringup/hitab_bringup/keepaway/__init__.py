"""Keepaway soccer as a job: train three keepers, evaluate them, compare with the paper."""

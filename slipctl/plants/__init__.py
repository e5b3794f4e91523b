"""Robots on their ground: the paper's slip model and MuJoCo."""

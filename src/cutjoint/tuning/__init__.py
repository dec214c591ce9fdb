"""Tuning: gains of control laws by the CPM paper's rule, by poles and by optimisation, and margins of loops."""

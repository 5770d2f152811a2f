"""The kinds of study, a module each, named as the key ``sequence`` says (`bench.study_model.models`).

A new kind is such a module, ``bench/<kind>_run.py``, which runs it, and ``reports/page_<kind>.py``, which
tells of it; nothing lists them.
"""

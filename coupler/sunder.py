"""What scripts import: scenes as messages, runs as arrays, series of runs; coupler/experiments/README.md has examples.

    PYTHONPATH=coupler python3 my_script.py
"""
from sunder_lab.campaign import Settings, member
from sunder_lab.dents import Dent, dent, dents
from sunder_lab.experiment import Experiment, Parameter, Plot
from sunder_lab.impact import Motion, energy_taken, impact, motion, perforated
from sunder_lab.measures import gives
from sunder_lab.pieces import Pieces, fragments, pieces, radial_cracks
from sunder_lab.results import Columns
from sunder_lab.scene import SCENES, BadSetting, Results, Scene
from sunder_lab.table import Mean, Table
from sunder_lab.tracks import Track, tracks
from sunder_lab.v50 import V50, Ballistic
from sunder_tools.errors import CommandError as Error

__all__ = ["BadSetting", "Ballistic", "Columns", "Dent", "Error", "Experiment", "Mean", "Motion", "Parameter",
           "Pieces", "Plot", "Results", "SCENES", "Scene", "Settings", "Table", "Track", "V50", "dent", "dents",
           "energy_taken", "fragments", "gives", "impact", "member", "motion", "perforated", "pieces", "radial_cracks",
           "tracks"]

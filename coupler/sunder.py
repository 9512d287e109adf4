"""Scenes as messages, runs as numpy arrays, series of runs.

One run, in SI units:

    import sunder

    scene = sunder.Scene.load(sunder.SCENES / "struck_glass.textproto")
    scene["bodies[ball].twist.linear.z"] = -20            # as `sunder run --set` takes it
    results = scene.run("out")                            # as `sunder run`, without pictures
    results.run["counts"]["fragments"]                    # run.json
    results.series["kinetic"]                             # a column of series.csv
    results.frames[-1].read(0).points                     # (n, 3) [m]; 0 shells, 1 cracks, 2 bodies
    sunder.Results("runs/glass")                          # a run that is there

What there is:

    Scene, SCENES, BadSetting     a scene, read, changed, checked, run; the folder of those that ship
    Results, Columns              a run folder; a table of it by columns
    pieces, fragments             areas of what is left (Pieces); the same as columns of a series
    tracks                        every piece through the frames, by its id (Track)
    radial_cracks                 cracks around a place
    dent, dents                   how deep and wide a shell is dented (Dent); all shells by name
    motion, impact                a body under a probe: impulse, forces (Motion); the same as columns
    perforated, energy_taken      whether a body went through; what it lost, and to what
    Experiment, Parameter, Plot   a series over values and seeds, its table and its plots
    V50                           the speed at which half of the panes are perforated (Ballistic)
    Table, Mean                   rows of results, with means and their intervals
    Settings, member, gives       where and how a series runs; one of its runs; columns of a measure
    Error                         what all of these raise, with a message for people

A checkout needs `PYTHONPATH=coupler`, or `pip install ./coupler` once. experiments/README.md has whole examples.
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

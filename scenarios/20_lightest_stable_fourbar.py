"""How thin may the aluminium four-bar's links be, with no unstable band below 1.3 times its speed?

The aluminium four-bar runs at 60 rad/s with a damping ratio of 0.1 %. Coupler and rocker are cut
from one sheet; the thinner it is, the lower the speeds at which vibrations grow. For every sheet
the first unstable band above the crank speed is sought by the Floquet multipliers; the lightest
linkage is that of the thinnest sheet whose band begins at 1.3 times the speed or above. Both
engines confirm it with twice the elements.

    python scenarios/20_lightest_stable_fourbar.py
"""  # noqa: D400 - a scenario asks a question

from pathlib import Path

from flexmech import example_model
from flexmech.studies import load_study, optimum_study, sweep_study

STUDY = """
model = "{model}"

[vary.sheet]
paths = ["links.coupler.in_plane_thickness", "links.rocker.in_plane_thickness"]
values = ["1.9 mm", "2 mm", "2.1 mm"]

[vary.damping-ratio]
values = ["0.1 %"]

[outputs]
margin = {{ quantity = "stable_speed_margin", speed = "60 rad/s" }}
mass = {{ quantity = "mass" }}

[[limits]]
output = "margin"
above = 0.3

[[goals]]
output = "mass"
"""

file = Path("sheets.toml")
file.write_text(STUDY.format(model=example_model("aluminium_fourbar").resolve().as_posix()))
study = load_study(file)
best = optimum_study(study)
every = sweep_study(study)
print(every.summary())
print(best.summary())
every.plot().savefig("sheets.png")

import numpy as np

import flexmech

resin = flexmech.load_mechanism("models/neat_resin_figure_8.toml")
wet = flexmech.HygrothermalState(temperature_rise=80.0, moisture=0.07)
paths = flexmech.coupler_paths(resin, np.radians(np.arange(0, 361, 5)), environment=wet)
print(paths.summary())
paths.plot().savefig("coupler_curve.png")

import numpy as np

import flexmech

mechanism = flexmech.load_mechanism("models/aluminium_fourbar.toml")
speeds = np.linspace(0.0, 300.0, 4)
diagram = flexmech.campbell(mechanism, speeds, speed_unit="rpm", orders=[9, 10], modes=2)
print(diagram.summary())
diagram.plot().savefig("campbell.png")
